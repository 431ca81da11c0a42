// SPDX-License-Identifier: Apache-2.0
// What robots that explore one building tell each other of themselves: where they are, which way they are about to
// drive, the place that each claims, and where else it could go. Plain values without any radio: whoever joins robots
// fills a TeamSight for one and sends on its TeamWord. World frame; metres, seconds, radians.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "hal/messages.hpp"
#include "hal/twist.hpp"

namespace g3d::nav {

inline constexpr std::size_t kMostTeammates = 15;
inline constexpr std::size_t kMostWayPoints = 16;
inline constexpr std::size_t kMostOffers = 8;

/// When a robot expects to be there, counted from its word. Straight lines lead from one to the next; the first is
/// where it stands.
struct WayPoint {
  float x_m = 0.0F;
  float y_m = 0.0F;
  float after_s = 0.0F;
};

/// A place that a robot could go to next.
struct Offer {
  hal::PlanarPose goal;     ///< T_world_base
  float travel_s = 0.0F;    ///< until it has that pose
  float gain_cells = 0.0F;  ///< unknown floor cells that it would see there, beyond what the offers before it show
};

/// Another robot as it last told of itself.
struct Teammate {
  std::uint64_t robot = 0;  ///< its id; the lower one has the right of way
  hal::PlanarPose T_world_base;
  hal::TimeNs told_ns = 0;  ///< when that was true, on our own clock
  float radius_m = 0.18F;   ///< of its body
  bool is_moving = false;   ///< else it stays where it is until it says otherwise
  std::array<WayPoint, kMostWayPoints> way{};
  std::size_t way_count = 0;
  bool has_goal = false;  ///< it claims that place
  hal::PlanarPose goal;
};

/// What a robot's navigator is told about its team; the latest one counts.
struct TeamSight {
  std::uint64_t self = 0;  ///< this robot's own id
  std::array<Teammate, kMostTeammates> mates{};
  std::size_t count = 0;
  /// Where the leader wants it to go: one of its own offers. Nothing: as it likes.
  std::optional<hal::PlanarPose> assigned;
};

/// What a navigator has to say to the others.
struct TeamWord {
  hal::PlanarPose T_world_base;
  bool is_moving = false;
  std::array<WayPoint, kMostWayPoints> way{};
  std::size_t way_count = 0;
  bool has_goal = false;
  hal::PlanarPose goal;
  std::array<Offer, kMostOffers> offers{};  ///< the one it would take by itself first
  std::size_t offer_count = 0;
};

}  // namespace g3d::nav
