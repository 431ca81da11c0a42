// SPDX-License-Identifier: Apache-2.0
// From a chain of cells to a way that can be driven: corners that are not needed are cut by line of sight on the cost
// grid, then points are set at equal distances. A shortcut touches no cell that is costlier than the costliest one on
// the stretch that it replaces (or than a cost that is always fine), so clearance is never worse than planned.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "nav/cell_grid.hpp"

namespace g3d::nav {

struct Waypoint {
  double x_m = 0.0;  ///< world frame
  double y_m = 0.0;
  bool operator==(const Waypoint&) const = default;
};

struct SmoothingOptions {
  std::uint8_t always_fine_cost = 20;  ///< shortcuts through cells up to this cost need no comparison
  std::uint8_t unknown_as = 100;       ///< what unknown cells count as; the planner's StepOptions::unknown_as
  double spacing_m = 0.05;             ///< of the points; 0: corners alone
  std::size_t max_span_cells = 400;    ///< no single straight stretch replaces more cells than this
};

class PathSmoother {
 public:
  /// For paths of at most this many cells (longer ones are returned as they are) and at most as many points.
  explicit PathSmoother(std::size_t max_cells = 1U << 16);

  /// Begins at the centre of the first cell, ends at that of the last. Valid until the next call. Allocates nothing.
  std::span<const Waypoint> smooth(const CellGrid<std::uint8_t>& cost, std::span<const Cell> path,
                                   const SmoothingOptions& options = {});
  /// Indices into the path of the corners that are left, of the last call.
  [[nodiscard]] std::span<const std::uint32_t> corners() const { return corners_; }

 private:
  std::vector<std::uint32_t> corners_;
  std::vector<Waypoint> points_;
};

/// The costliest of all cells that the straight line between two cell centres passes through or touches at a corner;
/// unknown cells count as `unknown_as`. kUnknownCost if the line leaves the grid.
[[nodiscard]] std::uint8_t costliest_on_line(const CellGrid<std::uint8_t>& cost, Cell from, Cell to,
                                             std::uint8_t unknown_as);

}  // namespace g3d::nav
