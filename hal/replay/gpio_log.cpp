// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/gpio_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "hal/image/file_bytes.hpp"
#include "hal/replay/decimal.hpp"
#include "hal/replay/log_lines.hpp"

namespace g3d::hal {
namespace {

constexpr TimeNs kMaxEdgeTime_ns = kMaxStamp_s * 1'000'000'000;

/// What is wrong with the line, or nullptr.
const char* parse_record(std::string_view line, GpioRecord& record) {
  const std::size_t first = line.find(' ');
  const std::size_t last = line.rfind(' ');
  if (first == line.npos || first == last) return "has not three words: t_ns line value";
  const auto [end, error] = std::from_chars(line.data(), line.data() + first, record.t_ns);
  if (error != std::errc{} || end != line.data() + first || record.t_ns < -kMaxEdgeTime_ns ||
      record.t_ns > kMaxEdgeTime_ns) {
    return "does not begin with nanoseconds";
  }
  const std::string_view name = line.substr(first + 1, last - first - 1);
  if (!is_gpio_name(name)) return "has no line's name, 1 to 63 printable characters without a space";
  const std::string_view value = line.substr(last + 1);
  if (value != "0" && value != "1") return "does not end with 0 or 1";
  record.line = name;
  record.level = value == "1";
  return nullptr;
}

}  // namespace

bool is_gpio_name(std::string_view text) {
  return !text.empty() && text.size() <= kMaxGpioName &&
         std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c < 0x7F; });
}

std::size_t format_gpio_line_to(char* out, TimeNs t_ns, std::string_view name, bool level) {
  char* at = std::to_chars(out, out + 20, std::clamp(t_ns, -kMaxEdgeTime_ns, kMaxEdgeTime_ns)).ptr;
  *at++ = ' ';
  at = std::copy_n(name.begin(), std::min(name.size(), kMaxGpioName), at);
  *at++ = ' ';
  *at++ = level ? '1' : '0';
  *at++ = '\n';
  return static_cast<std::size_t>(at - out);
}

Result<GpioLog> read_gpio_log(const std::string& path) {
  const Result<std::string> text = read_text_file(path, kMaxGpioLog_bytes);
  if (!text) return text.error();
  return parse_gpio_log(text.value(), path);
}

Result<GpioLog> parse_gpio_log(std::string_view text, std::string_view name) {
  GpioLog log;
  LogLines lines(text);
  while (const auto line = lines.next()) {
    GpioRecord record;
    const char* problem = parse_record(*line, record);
    if (problem == nullptr && !log.records.empty() && record.t_ns < log.records.back().t_ns) {
      problem = "is earlier than the one before";
    }
    if (problem != nullptr) {
      return Error{Reason::malformed,
                   fmt::format("{}:{}: a line that {}; is it a gpio.log?", name, lines.number(), problem)};
    }
    log.records.push_back(std::move(record));
  }
  log.torn_bytes = lines.torn_bytes();
  return log;
}

ReplayedGpio::ReplayedGpio(const GpioLog& log, const Clock& clock, std::array<std::string, kMaxGpioInputs> names)
    : log_(log), clock_(clock), names_(std::move(names)) {
  while (inputs_ < names_.size() && !names_[inputs_].empty()) ++inputs_;
}

bool ReplayedGpio::read_edge(GpioEdge& edge, TimeNs) {
  while (!is_over() && log_.records[next_].t_ns <= clock_.now()) {
    const GpioRecord& record = log_.records[next_++];
    const auto found = std::find(names_.begin(), names_.begin() + static_cast<std::ptrdiff_t>(inputs_), record.line);
    const auto input = static_cast<std::size_t>(found - names_.begin());
    if (input == inputs_) continue;
    levels_[input] = record.level;
    ++counts_.edges;
    edge = {record.t_ns, static_cast<std::uint8_t>(input), record.level};
    return true;
  }
  return false;
}

}  // namespace g3d::hal
