// SPDX-License-Identifier: Apache-2.0
// From the velocity that is wanted to one that the base can follow. Speeds are scaled together, so that the arc stays
// the arc that was checked for obstacles; changes are limited; a stop is neither.
#pragma once

#include "hal/kobuki/feedback.hpp"
#include "hal/twist.hpp"

namespace g3d::hal::kobuki {

struct SpeedLimitOptions {
  double max_forward_mps = kMaxSpeed_mps;
  double max_turn_radps = kMaxTurn_radps;
  double max_wheel_mps = kMaxSpeed_mps;  ///< of the outer wheel
  double speed_up_mps2 = 0.5;
  double slow_down_mps2 = 0.6;
  double turn_up_radps2 = 3.5;
  double turn_down_radps2 = 4.2;
};

/// One thread. Remembers what it allowed last: that is where the next change begins.
class SpeedLimits {
 public:
  explicit SpeedLimits(const SpeedLimitOptions& options = {}) : options_(options) {}
  /// The twist for the next `dt_s`. It goes over to the wanted curvature as fast as it may turn, speeds up no further
  /// before it is there, and brakes to a halt along the arc that it drives; braking waits for nothing. NaN and infinity
  /// are taken for zero; a `dt_s` above 0.1 counts as 0.1, so that a late caller does not cause a jump.
  [[nodiscard]] Twist limit(const Twist& wanted, double dt_s);
  /// Zero at once.
  Twist stop();
  /// What the base does instead, say after it was stopped by somebody else.
  void assume(const Twist& driven) { driven_ = driven; }
  [[nodiscard]] const Twist& driven() const { return driven_; }
  /// Limits of speed alone.
  [[nodiscard]] Twist scaled(const Twist& wanted) const;

 private:
  SpeedLimitOptions options_;
  Twist driven_;
};

}  // namespace g3d::hal::kobuki
