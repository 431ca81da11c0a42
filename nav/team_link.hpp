// SPDX-License-Identifier: Apache-2.0
// Between a robot's threads and whoever speaks with its team: the latest word of the one, the latest sight of the
// other. Both in the frame of the robot's own map, times on the robot's own clock.
#pragma once

#include "hal/latest.hpp"
#include "nav/teammates.hpp"

namespace g3d::nav {

struct TeamLink {
  hal::Latest<TeamWord> word;    ///< written by the navigator's thread
  hal::Latest<TeamSight> sight;  ///< written by who speaks with the team; navigator and mapper read it
};

}  // namespace g3d::nav
