// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/can_log.hpp"

#include <fmt/format.h>

#include "hal/image/file_bytes.hpp"
#include "hal/replay/log_lines.hpp"

namespace g3d::hal {

Result<CanLog> read_can_log(const std::string& path) {
  const Result<std::string> text = read_text_file(path, kMaxCanLog_bytes);
  if (!text) return text.error();
  return parse_can_log(text.value(), path);
}

Result<CanLog> parse_can_log(std::string_view text, std::string_view name) {
  CanLog log;
  LogLines lines(text);
  while (const auto line = lines.next()) {
    const can::CandumpLine parsed = can::parse_candump(*line);
    if (parsed.bad != can::BadCandump::none) {
      return Error{Reason::malformed, fmt::format("{}:{}: a line that {}; is it a log of candump -l?", name,
                                                  lines.number(), can::to_string(parsed.bad))};
    }
    if (!log.frames.empty() && parsed.stamped.t_ns < log.frames.back().t_ns) {
      return Error{Reason::malformed,
                   fmt::format("{}:{}: a frame earlier than the one before; frames must be in the order of time", name,
                               lines.number())};
    }
    if (log.frames.empty()) log.interface = parsed.interface;
    // One log, one bus: with several the stop node of one could be heard on the other.
    if (log.interface != parsed.interface) {
      return Error{Reason::unsupported,
                   fmt::format("{}:{}: a second interface; keep the lines of one, with grep", name, lines.number())};
    }
    log.frames.push_back(parsed.stamped);
  }
  log.torn_bytes = lines.torn_bytes();
  return log;
}

bool ReplayedCan::read(can::CanFrame& frame) {
  if (is_over() || log_.frames[next_].t_ns > clock_.now()) return false;
  frame = log_.frames[next_++].frame;
  ++counts_.received;
  counts_.error_frames += frame.is_error;
  return true;
}

}  // namespace g3d::hal
