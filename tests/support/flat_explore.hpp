// SPDX-License-Identifier: Apache-2.0
// Runs the explorer on a floor plan, as the robot's navigator would: decide, drive, report back.
#pragma once

#include "nav/explorer.hpp"
#include "tests/support/flat_run.hpp"

namespace g3d::tests {

/// Until it is home again, `limit_s` is over or that share is covered. `trace` prints every new goal.
[[nodiscard]] FlatResult run_explorer(FlatSim& sim, double limit_s, const nav::ExplorerConfig& config = {},
                                      bool trace = false, double enough = 2.0);

}  // namespace g3d::tests
