// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/base_control.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hal/kobuki/feedback.hpp"

namespace g3d::hal::kobuki {
namespace {

constexpr double kSmallest = 1e-4;  ///< m/s and rad/s: below, there is no such motion
constexpr double kHalfBase_mm = 1000.0 * kWheelBase_m / 2.0;
constexpr double kMaxInt16 = std::numeric_limits<std::int16_t>::max();

std::int16_t to_int16(double value) {
  return static_cast<std::int16_t>(std::clamp(value, double{std::numeric_limits<std::int16_t>::min()}, kMaxInt16));
}

}  // namespace

BaseControl to_base_control(const Twist& twist) {
  const double forward_mmps = 1000.0 * twist.forward_mps;
  const double turn_radps = twist.turn_radps;
  if (!std::isfinite(forward_mmps) || !std::isfinite(turn_radps)) return {};
  if (std::abs(turn_radps) < kSmallest) return {to_int16(forward_mmps), 0};
  const double radius_mm = forward_mmps / turn_radps;
  if (std::abs(radius_mm) > kMaxInt16) return {to_int16(forward_mmps), 0};
  if (std::abs(twist.forward_mps) < kSmallest || std::abs(radius_mm) < 2.0) {
    return {to_int16(kHalfBase_mm * turn_radps), 1};
  }
  const double outer_mm = radius_mm + std::copysign(kHalfBase_mm, radius_mm);
  return {to_int16(outer_mm * turn_radps), to_int16(radius_mm)};
}

Twist to_twist(const BaseControl& control) {
  if (control.radius_mm == 0) return {control.speed_mmps / 1000.0, 0.0};
  if (control.radius_mm == 1 || control.radius_mm == -1) return {0.0, control.speed_mmps / kHalfBase_mm};
  const double outer_mm = control.radius_mm + std::copysign(kHalfBase_mm, control.radius_mm);
  const double turn_radps = control.speed_mmps / outer_mm;
  return {control.radius_mm * turn_radps / 1000.0, turn_radps};
}

}  // namespace g3d::hal::kobuki
