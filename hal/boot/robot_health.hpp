// SPDX-License-Identifier: Apache-2.0
// What the robot's process says about itself, in systemd's notification protocol (sd_notify(3): datagrams of lines
// KEY=VALUE), and what follows for the hardware watchdog: it is fed only while the robot says that all its threads make
// progress, or while there is nothing that could hang because it is just being started. Plain; one thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "hal/messages.hpp"

namespace g3d::hal::boot {

/// One datagram.
struct Notice {
  bool is_ready = false;     ///< READY=1: its first frame is mapped
  bool is_alive = false;     ///< WATCHDOG=1: all of them make progress
  bool is_stopping = false;  ///< STOPPING=1
  std::string status;        ///< STATUS=...: for people, one line of printable text
  int unknown = 0;           ///< lines that mean nothing here
};
inline constexpr std::size_t kMostNotice_bytes = 1024;
[[nodiscard]] Notice parse_notice(std::string_view datagram);

class RobotHealth {
 public:
  struct Limits {
    TimeNs silent_ns = 2'000'000'000;   ///< a running robot speaks at least so often
    TimeNs start_ns = 120'000'000'000;  ///< from its start until it speaks at all
    TimeNs stop_ns = 60'000'000'000;    ///< from STOPPING=1 to its end: it saves the map
  };
  /// starting: nothing is mapped yet, as when no camera is plugged in; its threads run, if it has spoken.
  enum class State : std::uint8_t { away, starting, running, silent, stopping, overdue };

  explicit RobotHealth(const Limits& limits) : limits_(limits) {}

  void on_start(TimeNs now_ns);
  void on_notice(const Notice& notice, TimeNs now_ns);
  void on_end();

  [[nodiscard]] State state(TimeNs now_ns) const;
  [[nodiscard]] bool may_feed(TimeNs now_ns) const;

 private:
  Limits limits_;
  bool is_away_ = true;
  bool has_spoken_ = false;
  bool is_ready_ = false;
  bool is_stopping_ = false;
  TimeNs start_ns_ = 0;
  TimeNs heard_ns_ = 0;  ///< last WATCHDOG=1 (or READY=1)
};

[[nodiscard]] const char* to_string(RobotHealth::State state);

}  // namespace g3d::hal::boot
