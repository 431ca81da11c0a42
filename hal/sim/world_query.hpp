// SPDX-License-Identifier: Apache-2.0
// Plain questions to a world, one point or ray at a time in double precision: what a test holds the fast ray caster
// against, and what says how near a robot comes to things. Not for images.
#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "hal/sim/world.hpp"

namespace g3d::hal {

struct RayHit {
  static constexpr std::size_t kGrid = std::numeric_limits<std::size_t>::max();
  double t = std::numeric_limits<double>::infinity();  ///< in lengths of the direction; infinite if nothing is hit
  std::size_t primitive = 0;                           ///< index in World::primitives, or kGrid
};

/// Ray parameter at which the ray enters the solid; infinite if it never does, 0 if it starts inside.
[[nodiscard]] double intersect(const Primitive& solid, const std::array<double, 3>& origin_m,
                               const std::array<double, 3>& direction);

/// First solid along the ray; glass counts only if asked for.
[[nodiscard]] RayHit cast_ray(const World& world, TimeNs time_ns, const std::array<double, 3>& origin_m,
                              const std::array<double, 3>& direction, bool with_glass = false);

/// Whether the point lies within matter (solids and grid walls, glass included).
[[nodiscard]] bool is_solid(const World& world, TimeNs time_ns, const std::array<double, 3>& point_m);

/// Distance from a point to the nearest solid, 0 inside; cones count as the cylinder around them, the grid not at all.
[[nodiscard]] double clearance_m(const World& world, TimeNs time_ns, const std::array<double, 3>& point_m);

}  // namespace g3d::hal
