// SPDX-License-Identifier: Apache-2.0
// Decisions put into words.
#pragma once

#include "nav/goal_chooser.hpp"

namespace g3d::nav {

[[nodiscard]] inline Decision look_around_here(const PlanarPose& robot, double turn_rad, bool is_new) {
  Decision d;
  d.kind = DecisionKind::look_around;
  d.goal = robot;
  d.turn_rad = turn_rad;
  d.is_new = is_new;
  return d;
}

[[nodiscard]] inline Decision drive_to(const PlanarPose& goal, double expected_cells, const FrontiersLeft& left,
                                       bool is_new) {
  Decision d;
  d.kind = DecisionKind::goal;
  d.goal = goal;
  d.is_new = is_new;
  d.expected_cells = expected_cells;
  d.left = left;
  return d;
}

}  // namespace g3d::nav
