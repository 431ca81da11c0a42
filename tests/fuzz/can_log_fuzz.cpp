// SPDX-License-Identifier: Apache-2.0
// `can.log` and the frames in it from hostile hands: whatever is accepted is written and read again without a
// difference, every message that a frame is taken for becomes that frame again, and the stop node's word is the same
// twice.
#include <array>
#include <cstdlib>
#include <string>

#include "hal/can/estop_node.hpp"
#include "hal/replay/can_log.hpp"

namespace {

using namespace g3d::hal;

void check_message(const can::CanFrame& frame, const can::Message& message) {
  if (const auto* m = std::get_if<can::Heartbeat>(&message); m && !(can::encode(*m) == frame)) std::abort();
  if (const auto* m = std::get_if<can::Emergency>(&message); m && !(can::encode(*m) == frame)) std::abort();
  if (const auto* m = std::get_if<can::NmtOrder>(&message); m && !(can::encode(*m) == frame)) std::abort();
  can::RobotStatus status;
  if (can::decode_status(frame, status) && !(can::encode(status) == frame)) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  const std::string_view text(reinterpret_cast<const char*>(data), size_bytes);
  const Result<CanLog> log = parse_can_log(text, "fuzz.log");
  if (!log) return 0;
  std::string written;
  can::EstopNode first({1, 500'000'000}), second({1, 500'000'000});
  for (const can::StampedCanFrame& stamped : log.value().frames) {
    std::array<char, can::kMaxCandumpLine> line{};
    const std::size_t size = can::format_candump_to(line.data(), stamped, log.value().interface);
    if (size > line.size()) std::abort();
    written.append(line.data(), size);
    const can::Message message = can::decode(stamped.frame);
    check_message(stamped.frame, message);
    first.on_message(message, stamped.t_ns);
    second.on_message(message, stamped.t_ns);
    if (first.word(stamped.t_ns) != second.word(stamped.t_ns)) std::abort();
  }
  const Result<CanLog> again = parse_can_log(written, "again.log");
  if (!again || !(again.value().frames == log.value().frames)) std::abort();
  return 0;
}
