// SPDX-License-Identifier: Apache-2.0
#include "nav/spin.hpp"

#include <cmath>

namespace g3d::nav {

void Spin::start(double turn_rad, double heading_rad) {
  is_active_ = true;
  turn_rad_ = left_rad_ = turn_rad;
  heading_rad_ = heading_rad;
}

std::optional<hal::Twist> Spin::step(double heading_rad, const MotionLimits& limits) {
  left_rad_ -= wrap_angle(heading_rad - heading_rad_);
  heading_rad_ = heading_rad;
  if (std::fabs(left_rad_) > kSpun_rad && left_rad_ * turn_rad_ > 0.0) {
    return hal::Twist{0.0, turn_rate_to(left_rad_, limits)};
  }
  is_active_ = false;
  return std::nullopt;
}

}  // namespace g3d::nav
