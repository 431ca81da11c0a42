// SPDX-License-Identifier: Apache-2.0
// From where the robot is to where it should be: cells by A*, cut straight, beginning at the robot itself. A goal that
// has come to lie where the body cannot be is taken for the nearest place where it can, within a tolerance.
// One thread. Sized at construction; plan() allocates nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/twist.hpp"
#include "nav/astar.hpp"
#include "nav/cell_grid.hpp"
#include "nav/path_smoothing.hpp"

namespace g3d::nav {

struct Route {
  PathStatus status = PathStatus::unreachable;
  std::span<const Waypoint> points;  ///< robot and goal included; valid until the next plan()
  double length_m = 0.0;
  std::uint32_t expansions = 0;  ///< cells looked at
};

/// Whether there is no way for the body to get 1 m away from here, wherever to.
[[nodiscard]] bool is_hemmed_in(const CellGrid<std::uint8_t>& cost, const hal::PlanarPose& from);

class RoutePlanner {
 public:
  explicit RoutePlanner(std::size_t max_cells);

  /// `tolerance_m`: how far from the goal a substitute may lie; 0: none. With `through_unknown`, what nobody has seen
  /// may be free.
  Route plan(const CellGrid<std::uint8_t>& cost, const hal::PlanarPose& from, const hal::PlanarPose& to,
             double tolerance_m, bool through_unknown = false);

 private:
  void choose_goals(const CellGrid<std::uint8_t>& cost, Cell goal, double tolerance_m, bool through_unknown);

  AStar astar_;
  PathSmoother smoother_;
  std::vector<Cell> goals_;
  std::vector<Waypoint> points_;
};

}  // namespace g3d::nav
