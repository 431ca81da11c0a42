// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/base_dynamics.hpp"

#include <algorithm>

#include "hal/kobuki/feedback.hpp"

namespace g3d::hal {

WheelPair wheels_for_command(std::int16_t speed_mmps, std::int16_t radius_mm) {
  const double speed_mps = speed_mmps / 1000.0;
  const double half_m = kobuki::kWheelBase_m / 2.0;
  if (radius_mm == 0) return {speed_mps, speed_mps};
  if (radius_mm == 1 || radius_mm == -1) return {-speed_mps, speed_mps};
  const double radius_m = radius_mm / 1000.0;
  const double turn_radps = speed_mps / (radius_m + (radius_m > 0.0 ? half_m : -half_m));
  return {turn_radps * (radius_m - half_m), turn_radps * (radius_m + half_m)};
}

Twist twist_of(const WheelPair& speeds_mps) {
  return {(speeds_mps.left + speeds_mps.right) / 2.0, (speeds_mps.right - speeds_mps.left) / kobuki::kWheelBase_m};
}

void BaseDynamics::command(std::int16_t speed_mmps, std::int16_t radius_mm) {
  target_mps_ = wheels_for_command(speed_mmps, radius_mm);
  // Both by the same factor: a base that cannot keep up still drives the curve it was asked for.
  const double fastest = std::max({target_mps_.left, -target_mps_.left, target_mps_.right, -target_mps_.right});
  if (fastest > options_.max_wheel_speed_mps) {
    target_mps_.left *= options_.max_wheel_speed_mps / fastest;
    target_mps_.right *= options_.max_wheel_speed_mps / fastest;
  }
}

WheelPair BaseDynamics::step(double dt_s) {
  const auto advance = [&](double& speed_mps, double target_mps) {
    const double before_mps = speed_mps;
    const double wanted_mps = (target_mps - speed_mps) * (dt_s / (dt_s + options_.motor_lag_s));
    const double most_mps = options_.max_acceleration_mps2 * dt_s;
    speed_mps += std::clamp(wanted_mps, -most_mps, most_mps);
    if (speed_mps - target_mps < 1e-6 && target_mps - speed_mps < 1e-6) speed_mps = target_mps;
    return (before_mps + speed_mps) / 2.0 * dt_s;
  };
  return {advance(speeds_mps_.left, target_mps_.left), advance(speeds_mps_.right, target_mps_.right)};
}

}  // namespace g3d::hal
