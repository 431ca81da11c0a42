// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/robot_health.hpp"

#include <algorithm>

namespace g3d::hal::boot {

Notice parse_notice(std::string_view datagram) {
  Notice notice;
  datagram = datagram.substr(0, kMostNotice_bytes);
  while (!datagram.empty()) {
    const std::size_t end = std::min(datagram.find('\n'), datagram.size());
    const std::string_view line = datagram.substr(0, end);
    datagram.remove_prefix(std::min(end + 1, datagram.size()));
    if (line == "READY=1") {
      notice.is_ready = true;
    } else if (line == "WATCHDOG=1") {
      notice.is_alive = true;
    } else if (line == "STOPPING=1") {
      notice.is_stopping = true;
    } else if (line.starts_with("STATUS=")) {
      notice.status = line.substr(7);
      for (char& c : notice.status) c = c >= ' ' && c <= '~' ? c : '?';
    } else if (!line.empty()) {
      ++notice.unknown;
    }
  }
  return notice;
}

void RobotHealth::on_start(TimeNs now_ns) {
  is_away_ = has_spoken_ = is_ready_ = is_stopping_ = false;
  start_ns_ = now_ns;
}

void RobotHealth::on_notice(const Notice& notice, TimeNs now_ns) {
  if (is_away_) return;
  if (notice.is_stopping && !is_stopping_) {
    is_stopping_ = true;
    heard_ns_ = now_ns;
  }
  if (is_stopping_) return;
  const bool is_news = notice.is_alive || (notice.is_ready && !is_ready_);
  is_ready_ = is_ready_ || notice.is_ready;
  has_spoken_ = has_spoken_ || is_news;
  if (is_news) heard_ns_ = now_ns;
}

void RobotHealth::on_end() { is_away_ = true; }

RobotHealth::State RobotHealth::state(TimeNs now_ns) const {
  if (is_away_) return State::away;
  if (is_stopping_) return now_ns - heard_ns_ > limits_.stop_ns ? State::overdue : State::stopping;
  if (!has_spoken_) return now_ns - start_ns_ > limits_.start_ns ? State::overdue : State::starting;
  if (now_ns - heard_ns_ > limits_.silent_ns) return State::silent;
  return is_ready_ ? State::running : State::starting;
}

bool RobotHealth::may_feed(TimeNs now_ns) const {
  const State now = state(now_ns);
  return now != State::silent && now != State::overdue;
}

const char* to_string(RobotHealth::State state) {
  switch (state) {
    case RobotHealth::State::away:
      return "away";
    case RobotHealth::State::starting:
      return "starting";
    case RobotHealth::State::running:
      return "running";
    case RobotHealth::State::silent:
      return "silent";
    case RobotHealth::State::stopping:
      return "stopping";
    case RobotHealth::State::overdue:
      return "overdue";
  }
  return "?";
}

}  // namespace g3d::hal::boot
