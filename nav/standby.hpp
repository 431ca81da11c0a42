// SPDX-License-Identifier: Apache-2.0
// When the robot stands for reasons that are not its own (paused, forbidden by the safety table), how long it did, and
// when a robot that needs help tries again by itself.
#pragma once

#include "hal/messages.hpp"
#include "nav/mission.hpp"

namespace g3d::nav {

using hal::TimeNs;

class Standby {
 public:
  struct Step {
    bool began = false;
    bool ended = false;
    TimeNs stood_ns = 0;  ///< since the last step; not to be held against any goal
  };

  Standby(double retry_s, int max_retries);

  void start(TimeNs now) { last_step_ns_ = now; }
  /// Once per step: whether the robot must stand now.
  Step step(bool must_stand, TimeNs now);

  /// Nothing helps any more: it tries again in a while,
  void call_for_help(TimeNs now) { retry_ns_ = now + retry_wait_ns_; }
  /// which is now. True at most so many times,
  [[nodiscard]] bool should_retry(MissionState state, TimeNs now);
  /// until somebody has come.
  void forget_retries() { retries_ = 0; }

 private:
  TimeNs retry_wait_ns_;
  int max_retries_;
  bool is_standing_ = false;
  TimeNs last_step_ns_ = 0;
  TimeNs retry_ns_ = -1;
  int retries_ = 0;
};

}  // namespace g3d::nav
