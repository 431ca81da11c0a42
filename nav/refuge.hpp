// SPDX-License-Identifier: Apache-2.0
// Where a robot that stands in the way of others finds room: the nearest place that none of those who go first comes
// by, and that it reaches without meeting them. Found in a window around the robot, cell by cell in order of distance.
// One thread. Sized at construction; the work of a call is bounded by the window.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "hal/messages.hpp"
#include "nav/cell_grid.hpp"
#include "nav/right_of_way.hpp"
#include "nav/teammates.hpp"

namespace g3d::nav {

class Refuge {
 public:
  static constexpr double kReach_m = 6.0;  ///< of the window to each side

  explicit Refuge(double resolution_m);

  /// `cost`: of the floor, with the bodies that stand about. Nothing: there is no such place near.
  [[nodiscard]] std::optional<hal::PlanarPose> find(const CellGrid<std::uint8_t>& cost, const TeamSight& sight,
                                                    hal::TimeNs now, const hal::PlanarPose& T_world_base,
                                                    const RightOfWayConfig& config);

 private:
  void mark_ways(const CellGrid<std::uint8_t>& cost, const TeamSight& sight, hal::TimeNs now,
                 const RightOfWayConfig& config);
  void mark(const CellGrid<std::uint8_t>& cost, const Waypoint& at, double radius_m);
  [[nodiscard]] std::size_t index(int dx, int dy) const {
    return static_cast<std::size_t>(dy + reach_cells_) * static_cast<std::size_t>(2 * reach_cells_ + 1) +
           static_cast<std::size_t>(dx + reach_cells_);
  }

  int reach_cells_;
  Cell centre_;
  std::vector<std::uint8_t> on_way_;  ///< per cell of the window: somebody who goes first comes by
  std::vector<std::uint16_t> steps_;  ///< from the robot; 0: not met
  std::vector<Cell> queue_;           ///< relative to the centre
};

}  // namespace g3d::nav
