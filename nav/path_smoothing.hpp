// SPDX-License-Identifier: Apache-2.0
// From a chain of cells to a way that can be driven: corners that are not needed are cut by line of sight on the cost
// grid, then points are set at equal distances. A shortcut touches no cell that is costlier than the costliest one on
// the stretch that it replaces (or than a cost that is always fine), so clearance is never worse than planned; and its
// cost as a whole is not higher, so it does not follow a wall closely because of one narrow door.
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
  /// Longer paths are cut after this many cells.
  explicit PathSmoother(std::size_t max_cells = 1U << 16);

  /// Begins at the centre of the first cell, ends at that of the last. Valid until the next call. Allocates nothing.
  std::span<const Waypoint> smooth(const CellGrid<std::uint8_t>& cost, std::span<const Cell> path,
                                   const SmoothingOptions& options = {});
  /// Indices into the path of the corners that are left, of the last call.
  [[nodiscard]] std::span<const std::uint32_t> corners() const { return corners_; }

 private:
  void pick_corners(const CellGrid<std::uint8_t>& cost, std::span<const Cell> path, const SmoothingOptions& options);
  void set_points(const CellGrid<std::uint8_t>& cost, std::span<const Cell> path, double spacing_m);

  std::size_t max_cells_;
  std::vector<std::uint32_t> corners_;
  std::vector<Waypoint> points_;
};

/// What a straight line between two cell centres crosses.
struct LineCost {
  std::uint8_t costliest =
      0;               ///< of all cells that it passes through or touches at a corner; 255 if it leaves the grid
  double total = 0.0;  ///< length in cells, weighted like the planner's steps
};
/// Unknown cells count as `unknown_as`.
[[nodiscard]] LineCost cost_of_line(const CellGrid<std::uint8_t>& cost, Cell from, Cell to, std::uint8_t unknown_as);

}  // namespace g3d::nav
