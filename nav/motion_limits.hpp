// SPDX-License-Identifier: Apache-2.0
// How fast the robot may move, and the two equations of stopping in time. Plain numbers; the board sets them.
#pragma once

#include <algorithm>
#include <cmath>

#include "hal/twist.hpp"

namespace g3d::nav {

struct MotionLimits {
  double max_speed_mps = 0.5;
  double max_turn_radps = 1.5;
  double deceleration_mps2 = 0.6;  ///< what the base brakes with
  double turn_deceleration_radps2 = 3.0;
  double reaction_s = 0.2;        ///< from "seen in the map" to "the wheels slow down"
  double turn_reaction_s = 0.06;  ///< command to wheel: a turn on the spot endangers nobody
  double crawl_speed_mps = 0.1;   ///< where nobody has looked yet, and backwards
  double body_radius_m = 0.18;
  double touch_margin_m = 0.01;  ///< kept between body and occupied cells
};

/// Largest speed from which the robot stands still after `distance_m`: v t + v^2 / (2 a) = d.
[[nodiscard]] inline double speed_to_stop_within(double distance_m, double deceleration_mps2, double reaction_s) {
  if (!(distance_m > 0.0)) return 0.0;
  const double a = deceleration_mps2;
  return a * (std::sqrt(reaction_s * reaction_s + 2.0 * distance_m / a) - reaction_s);
}

/// The way covered until the robot stands, from `speed_mps`.
[[nodiscard]] inline double distance_to_stop(double speed_mps, double deceleration_mps2, double reaction_s) {
  return speed_mps * reaction_s + speed_mps * speed_mps / (2.0 * deceleration_mps2);
}

/// In (-pi, pi]. For angles of a few turns at most.
[[nodiscard]] inline double wrap_angle(double angle_rad) {
  constexpr double kPi = 3.14159265358979323846;
  while (angle_rad > kPi) angle_rad -= 2.0 * kPi;
  while (angle_rad <= -kPi) angle_rad += 2.0 * kPi;
  return angle_rad;
}

/// Turn rate that ends at rest after `error_rad`, with its sign.
[[nodiscard]] inline double turn_rate_to(double error_rad, const MotionLimits& limits) {
  const double rate =
      speed_to_stop_within(std::fabs(error_rad), limits.turn_deceleration_radps2, limits.turn_reaction_s);
  return std::copysign(std::min(rate, limits.max_turn_radps), error_rad);
}

}  // namespace g3d::nav
