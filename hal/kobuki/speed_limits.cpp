// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/speed_limits.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::hal::kobuki {
namespace {

constexpr double kMaxStep_s = 0.1;
/// What was scaled once is not scaled again for its last digit.
constexpr double kRounding = 1e-12;

/// How far one axis gets from `from` to `to` in `dt_s`; through zero it slows down first, then speeds up.
double reached(double from, double to, double up_per_s2, double down_per_s2, double dt_s) {
  double allowed = 0.0;
  if (from * to < 0.0) {
    const double to_zero_s = std::abs(from) / down_per_s2;
    allowed = to_zero_s >= dt_s ? down_per_s2 * dt_s : std::abs(from) + up_per_s2 * (dt_s - to_zero_s);
  } else {
    allowed = (std::abs(to) < std::abs(from) ? down_per_s2 : up_per_s2) * dt_s;
  }
  return std::abs(to - from) <= allowed ? to : from + std::copysign(allowed, to - from);
}

/// The turn that belongs to `forward_mps` on the way from `driven` to `target`.
double turn_on_the_way(const Twist& driven, const Twist& target, double forward_mps) {
  if (forward_mps == target.forward_mps) return target.turn_radps;
  if (driven.forward_mps * target.forward_mps >= 0.0 && target.forward_mps != 0.0) {
    const double most = std::max(std::abs(driven.turn_radps), std::abs(target.turn_radps));
    return std::clamp(target.turn_radps * forward_mps / target.forward_mps, -most, most);
  }
  if (target.forward_mps == 0.0 && target.turn_radps != 0.0) return target.turn_radps;
  return driven.turn_radps * forward_mps / driven.forward_mps;  // brakes along the arc that is driven
}

}  // namespace

Twist SpeedLimits::scaled(const Twist& wanted) const {
  const double forward_mps = std::abs(wanted.forward_mps), turn_radps = std::abs(wanted.turn_radps);
  if (!std::isfinite(forward_mps) || !std::isfinite(turn_radps)) return {};
  const double outer_mps = forward_mps + turn_radps * kWheelBase_m / 2.0;
  double scale = 1.0;
  if (forward_mps > options_.max_forward_mps + kRounding)
    scale = std::min(scale, options_.max_forward_mps / forward_mps);
  if (turn_radps > options_.max_turn_radps + kRounding) scale = std::min(scale, options_.max_turn_radps / turn_radps);
  if (outer_mps > options_.max_wheel_mps + kRounding) scale = std::min(scale, options_.max_wheel_mps / outer_mps);
  return {scale * wanted.forward_mps, scale * wanted.turn_radps};
}

Twist SpeedLimits::limit(const Twist& wanted, double dt_s) {
  const Twist target = scaled(wanted);
  if (!(dt_s > 0.0)) return driven_;
  const double step_s = std::min(dt_s, kMaxStep_s);
  double forward_mps =
      reached(driven_.forward_mps, target.forward_mps, options_.speed_up_mps2, options_.slow_down_mps2, step_s);
  const double turn_wanted_radps = turn_on_the_way(driven_, target, forward_mps);
  const double turn_radps =
      reached(driven_.turn_radps, turn_wanted_radps, options_.turn_up_radps2, options_.turn_down_radps2, step_s);
  const double before_mps = std::abs(driven_.forward_mps);
  if (std::abs(forward_mps) > before_mps && turn_radps != turn_wanted_radps) {
    // No faster before it is on the arc that is wanted.
    const double part = turn_wanted_radps != 0.0 ? turn_radps / turn_wanted_radps : 0.0;
    const double on_arc_mps = std::abs(forward_mps) * std::clamp(part, 0.0, 1.0);
    forward_mps = std::copysign(std::max(before_mps, on_arc_mps), forward_mps);
  }
  driven_ = {forward_mps, turn_radps};
  const double half_base_m = kWheelBase_m / 2.0;
  if (std::abs(forward_mps) + std::abs(turn_radps) * half_base_m > options_.max_wheel_mps + kRounding) {
    // Both are within their limits, but not yet the outer wheel: turning goes before speed, as far as braking allows.
    const double slowest_mps = std::max(0.0, before_mps - options_.slow_down_mps2 * step_s);
    const double room_mps = std::max(slowest_mps, options_.max_wheel_mps - std::abs(turn_radps) * half_base_m);
    driven_.forward_mps = std::copysign(std::min(std::abs(forward_mps), room_mps), forward_mps);
    const double turn_room_radps = (options_.max_wheel_mps - std::abs(driven_.forward_mps)) / half_base_m;
    driven_.turn_radps = std::copysign(std::min(std::abs(turn_radps), turn_room_radps), turn_radps);
  }
  return driven_;
}

Twist SpeedLimits::stop() {
  driven_ = {};
  return driven_;
}

}  // namespace g3d::hal::kobuki
