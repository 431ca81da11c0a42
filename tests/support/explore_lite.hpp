// SPDX-License-Identifier: Apache-2.0
// A yardstick: greedy frontier exploration as the ROS package explore_lite does it, with its published parameters.
// Frontiers are connected unknown cells beside free ones that a breadth-first search from the robot meets; the goal is
// a frontier's centroid, with heading 0; failed goals and those without progress are never tried again.
#pragma once

#include "tests/support/flat_run.hpp"

namespace g3d::tests {

struct ExploreLiteConfig {
  double potential_scale = 3.0;
  double gain_scale = 1.0;
  double min_frontier_m = 0.75;
  double period_s = 3.0;  ///< 0.33 Hz
  double progress_timeout_s = 30.0;
};

/// Explores until nothing is left or `limit_s` is over.
[[nodiscard]] FlatResult run_explore_lite(FlatSim& sim, double limit_s, const ExploreLiteConfig& config = {});

}  // namespace g3d::tests
