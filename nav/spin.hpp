// SPDX-License-Identifier: Apache-2.0
// A look around: the body turns on the spot by a given angle, however many turns that is.
#pragma once

#include <optional>

#include "hal/twist.hpp"
#include "nav/motion_limits.hpp"

namespace g3d::nav {

class Spin {
 public:
  /// `turn_rad`: signed, may be a full turn.
  void start(double turn_rad, double heading_rad);
  void clear() { is_active_ = false; }
  [[nodiscard]] bool is_active() const { return is_active_; }
  /// The velocity to command now; none when it has turned far enough, which ends it.
  [[nodiscard]] std::optional<hal::Twist> step(double heading_rad, const MotionLimits& limits);

 private:
  static constexpr double kSpun_rad = 0.05;

  bool is_active_ = false;
  double turn_rad_ = 0.0;
  double left_rad_ = 0.0;
  double heading_rad_ = 0.0;  ///< of the last step
};

}  // namespace g3d::nav
