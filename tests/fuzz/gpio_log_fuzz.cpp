// SPDX-License-Identifier: Apache-2.0
// `gpio.log` from hostile hands: whatever is accepted is written and read again without a difference, and a switch that
// replays it gets to an end.
#include <array>
#include <cstdlib>
#include <string>

#include "hal/gpio/gpio_safety.hpp"
#include "hal/replay/gpio_log.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  using namespace g3d::hal;
  const Result<GpioLog> log = parse_gpio_log({reinterpret_cast<const char*>(data), size_bytes}, "fuzz.log");
  if (!log) return 0;
  std::string written;
  for (const GpioRecord& record : log.value().records) {
    std::array<char, kMaxGpioLogLine> line{};
    const std::size_t size = format_gpio_line_to(line.data(), record.t_ns, record.line, record.level);
    if (size > line.size()) std::abort();
    written.append(line.data(), size);
  }
  const Result<GpioLog> again = parse_gpio_log(written, "again.log");
  if (!again || !(again.value().records == log.value().records)) std::abort();
  if (log.value().records.empty()) return 0;

  DataClock clock;
  GpioSafetyOptions options;
  options.names = {log.value().records.front().line, log.value().records.back().line};
  options.estop.lines = 2;
  ReplayedGpio lines(log.value(), clock, options.names);
  GpioSafety safety(lines, options);
  for (const GpioRecord& record : log.value().records) {
    clock.advance_to(record.t_ns);
    (void)safety.look(record.t_ns);
  }
  return 0;
}
