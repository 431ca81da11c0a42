// SPDX-License-Identifier: Apache-2.0
// Velocity as the base wants it: speed of the outer wheel and radius of the arc (kobuki_documentation, conversions,
// with the brackets as the reference driver sets them).
#pragma once

#include <cstdint>

#include "hal/twist.hpp"

namespace g3d::hal::kobuki {

/// Radius 0 = straight on; radius 1 = turning on the spot, speed positive to the left; else the arc's radius at the
/// base's centre, positive if the arc's centre lies to the left.
struct BaseControl {
  std::int16_t speed_mmps = 0;
  std::int16_t radius_mm = 0;
  bool operator==(const BaseControl&) const = default;
};

/// Clamps to 16 bits and drops fractions, nothing else: limit the twist before. NaN and infinity are a stop. Never
/// gives radius -1, which a base may take for turning on the spot, the wrong way round.
[[nodiscard]] BaseControl to_base_control(const Twist& twist);
/// What a base does with it.
[[nodiscard]] Twist to_twist(const BaseControl& control);

}  // namespace g3d::hal::kobuki
