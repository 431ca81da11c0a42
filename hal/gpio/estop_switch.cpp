// SPDX-License-Identifier: Apache-2.0
#include "hal/gpio/estop_switch.hpp"

namespace g3d::hal {

const char* to_string(EstopFault fault) {
  switch (fault) {
    case EstopFault::none:
      return "none";
    case EstopFault::unreadable:
      return "unreadable";
    case EstopFault::discrepancy:
      return "discrepancy";
  }
  return "unknown";
}

void EstopSwitch::set(std::size_t at, bool is_closed, TimeNs t_ns) {
  Line& line = lines_[at];
  if (line.was_seen && line.is_closed == is_closed) return;
  if (line.was_seen && is_closed) {  // it closes: how long was it open?
    const bool is_glitch = t_ns - line.since_ns < options_.glitch_ns;
    glitches_ += is_glitch;
    line.opened_for_long |= !is_glitch;
  }
  line.was_seen = true;
  line.is_closed = is_closed;
  line.since_ns = t_ns;
}

void EstopSwitch::on_edge(const GpioEdge& edge) {
  if (edge.input >= options_.lines) return;
  lines_[edge.input].is_unreadable = false;
  set(edge.input, edge.level == closed_level(edge.input), edge.t_ns);
}

void EstopSwitch::on_level(std::size_t line, bool level, TimeNs now_ns) {
  if (line >= options_.lines) return;
  lines_[line].is_unreadable = false;
  set(line, level == closed_level(line), now_ns);
}

void EstopSwitch::on_unreadable(std::size_t line, TimeNs now_ns) {
  if (line >= options_.lines) return;
  lines_[line].is_unreadable = true;
  // No disturbance: this is over when somebody has seen the line again, and then it was a stop.
  lines_[line].opened_for_long = true;
  set(line, false, now_ns);
}

StopWord EstopSwitch::word(TimeNs now_ns) {
  bool open_for_long = false, all_settled = true, any_unreadable = false, any_closed = false, any_open = false;
  for (std::size_t i = 0; i < options_.lines; ++i) {
    Line& line = lines_[i];
    any_unreadable |= line.is_unreadable;
    open_for_long |= line.opened_for_long;
    line.opened_for_long = false;
    const bool is_closed = line.was_seen && line.is_closed;
    (is_closed ? any_closed : any_open) = true;
    if (!is_closed) open_for_long |= line.was_seen && now_ns - line.since_ns >= options_.glitch_ns;
    all_settled &= is_closed && now_ns - line.since_ns >= options_.settle_ns;
  }
  const bool disagree = any_closed && any_open;
  if (disagree && !disagrees_) disagrees_since_ns_ = now_ns;
  disagrees_ = disagree;

  if (any_unreadable) {
    fault_ = EstopFault::unreadable;
  } else if (disagrees_ && now_ns - disagrees_since_ns_ >= options_.discrepancy_ns) {
    fault_ = EstopFault::discrepancy;
  } else if (all_settled) {
    fault_ = EstopFault::none;
  }
  if (open_for_long) {
    presses_ += !is_stopped_;
    is_stopped_ = true;
  } else if (all_settled) {
    is_stopped_ = false;
    was_released_ = true;
  }
  if (is_stopped_) return StopWord::stop;
  return was_released_ ? StopWord::go : StopWord::not_yet;
}

}  // namespace g3d::hal
