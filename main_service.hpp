// SPDX-License-Identifier: Apache-2.0
// What a robot tells whoever started it, where that is systemd or our own first process: that it maps, that all its
// threads go on, what it is about, that it ends.
#pragma once

#include "hal/linux/service_notify.hpp"
#include "hal/messages.hpp"
#include "nav/live_status.hpp"

namespace g3d {

class ServiceReport {
 public:
  /// While every thread makes progress, about once a second; any one thread.
  void all_alive() { (void)notify_.alive(); }
  /// From time to time, by the thread that looks after the robot. Ready with the first integrated frame.
  void look(hal::TimeNs now_ns, std::uint64_t integrated, const nav::LiveStatus& status);
  /// The robot stands; files are still to be written.
  void stopping();
  [[nodiscard]] bool is_supervised() const { return notify_.is_supervised(); }
  /// all_alive() is due so often; 0: nobody waits for it.
  [[nodiscard]] hal::TimeNs alive_period_ns() const { return notify_.alive_period_ns(); }

 private:
  hal::ServiceNotify notify_;
  bool is_ready_ = false;
  hal::TimeNs next_status_ns_ = 0;
};

}  // namespace g3d
