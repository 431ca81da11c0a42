// SPDX-License-Identifier: Apache-2.0
// A yardstick: the tour that one would drive with full knowledge of the building. Views (place and heading) are chosen
// by greedy set cover of what is observable, then ordered as a travelling salesman would (nearest neighbour, 2-opt,
// or-opt) by the time of driving and turning.
#pragma once

#include "tests/support/flat_run.hpp"

namespace g3d::tests {

/// Drives it in `sim`, skipping views of which everything has been seen on the way. `observable` and `reachable` are of
/// the same plan; covers `share` of what is observable.
[[nodiscard]] FlatResult run_offline_tour(FlatSim& sim, const FlatWorld& world,
                                          const nav::CellGrid<std::uint8_t>& reachable,
                                          const nav::CellGrid<std::uint8_t>& observable, double share = 0.992);

}  // namespace g3d::tests
