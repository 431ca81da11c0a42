// SPDX-License-Identifier: Apache-2.0
// The way that a robot tells its teammates: what it is about to drive, in few points, with the time at which it expects
// to be at each.
#pragma once

#include <array>
#include <cstddef>

#include "hal/twist.hpp"
#include "nav/path_track.hpp"
#include "nav/teammates.hpp"

namespace g3d::nav {

struct WayTold {
  std::array<WayPoint, kMostWayPoints> points{};
  std::size_t count = 0;
};

/// From the robot along the rest of its path, to the end or as far as the points reach; nowhere farther from the path
/// than kTellOff_m. `first_turn_s`: how long it turns on the spot before it drives. One point where there is no path.
/// Allocates nothing.
[[nodiscard]] WayTold tell_way(const PathTrack& track, const hal::PlanarPose& T_world_base, double speed_mps,
                               double first_turn_s);

/// Of a robot that stays where it is.
[[nodiscard]] WayTold tell_place(const hal::PlanarPose& T_world_base);

inline constexpr double kTellOff_m = 0.06;
inline constexpr double kTellFar_m = 12.0;

}  // namespace g3d::nav
