// SPDX-License-Identifier: Apache-2.0
// A yardstick: explore_lite (lite_plan.hpp) drives the robot of the flat simulation.
#pragma once

#include "tests/support/flat_run.hpp"
#include "tests/support/lite_plan.hpp"

namespace g3d::tests {

/// Explores until nothing is left or `limit_s` is over.
[[nodiscard]] FlatResult run_explore_lite(FlatSim& sim, double limit_s, const ExploreLiteConfig& config = {});

}  // namespace g3d::tests
