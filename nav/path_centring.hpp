// SPDX-License-Identifier: Apache-2.0
// Paths lead through the middles of cells. Where it is tight, the middle of the gap may be the edge between two cells:
// points of a path that come near to obstacles move sideways, to where it is as far to one side as to the other.
#pragma once

#include <cstdint>
#include <span>

#include "nav/cell_grid.hpp"
#include "nav/path_smoothing.hpp"

namespace g3d::nav {

/// Distance to the nearest obstacle, an occupied cell (kLethalCost) being its whole square; at most `reach_m`.
[[nodiscard]] double clearance_to_squares_m(const CellGrid<std::uint8_t>& cost, const Waypoint& at, double reach_m);

/// Points with less than `wide_m` of clearance move by a cell at most. The first and the last stay.
void centre_path(const CellGrid<std::uint8_t>& cost, std::span<Waypoint> path, double wide_m);

}  // namespace g3d::nav
