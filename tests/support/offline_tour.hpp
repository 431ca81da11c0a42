// SPDX-License-Identifier: Apache-2.0
// A yardstick: the tour planned with full knowledge (tour_plan.hpp), driven in the flat simulation.
#pragma once

#include "tests/support/flat_run.hpp"

namespace g3d::tests {

/// Drives it in `sim`, skipping views of which everything has been seen on the way. `observable` and `reachable` are of
/// the same plan; covers `share` of what is observable.
[[nodiscard]] FlatResult run_offline_tour(FlatSim& sim, const FlatWorld& world,
                                          const nav::CellGrid<std::uint8_t>& reachable,
                                          const nav::CellGrid<std::uint8_t>& observable, double share = 0.992);

}  // namespace g3d::tests
