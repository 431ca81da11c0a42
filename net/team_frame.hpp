// SPDX-License-Identifier: Apache-2.0
// Each robot drives in the frame of its own map, and robots speak of places in the world that they share. Where a map
// stands in it may be put right while they drive (pose_refiner.hpp); so words are turned on their way out and on their
// way in. On the floor: maps stand level. Any thread.
#pragma once

#include "hal/messages.hpp"
#include "nav/teammates.hpp"

namespace g3d::net {

/// What a navigator says of its map's frame, in the world's.
[[nodiscard]] nav::TeamWord in_world(const nav::TeamWord& in_map, const hal::Pose& T_world_map);
/// What is known of a team in the world's frame, in the map's.
[[nodiscard]] nav::TeamSight in_map(const nav::TeamSight& in_world, const hal::Pose& T_world_map);

}  // namespace g3d::net
