// SPDX-License-Identifier: Apache-2.0
// Drives the robot of a FlatSim to poses: shortest path over the costs, then a plain pursuit of it. The same driver
// serves every way of exploring that is compared.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/support/flat_sim.hpp"

namespace g3d::tests {

/// A* over cells: 8-connected, cost of a step = its length times (1 + cost / 64).
class FlatPlanner {
 public:
  /// Cells from start to goal, both included; empty if there is no way. `through_unknown`: unknown cells cost like free
  /// ones.
  std::vector<nav::Cell> plan(const nav::CellGrid<std::uint8_t>& cost, nav::Cell from, nav::Cell to,
                              bool through_unknown);

 private:
  struct Open {
    std::int32_t estimate = 0;
    std::uint32_t cell = 0;
  };
  std::vector<std::int32_t> distance_;
  std::vector<std::uint8_t> came_;
  std::vector<std::uint32_t> touched_;
  std::vector<Open> heap_;
};

enum class DriveState : std::uint8_t { driving, arrived, no_path, stuck };

class FlatDriver {
 public:
  explicit FlatDriver(FlatSim& sim, bool through_unknown) : sim_(sim), through_unknown_(through_unknown) {}

  /// `costs`: what to plan on; the sim's own unless given.
  void set_goal(const hal::PlanarPose& goal, const nav::CellGrid<std::uint8_t>* costs = nullptr);
  /// One step of the sim, or none if it says anything but `driving`.
  DriveState step();
  [[nodiscard]] const std::vector<nav::Cell>& path() const { return path_; }

 private:
  [[nodiscard]] bool is_passable(nav::Cell c) const;
  [[nodiscard]] bool line_is_clear(nav::Cell a, nav::Cell b, int worst) const;
  void replan();

  FlatSim& sim_;
  bool through_unknown_;
  const nav::CellGrid<std::uint8_t>* costs_ = nullptr;
  hal::PlanarPose goal_;
  std::vector<nav::Cell> path_;
  std::size_t next_ = 0;
  bool turning_ = false;
  bool in_place_ = false;
  int blocked_ = 0;
  int bumped_ = 0;            ///< steps for which it is careful after a bump
  hal::PlanarPose progress_;  ///< where it was when it last got on
  double progress_s_ = 0.0;
  FlatPlanner planner_;
};

}  // namespace g3d::tests
