// SPDX-License-Identifier: Apache-2.0
// A voxel map of a flat world, written as a mapper would see it from a robot with a level camera: the floor from 1.1 m
// on, walls from 0.8 m on, and nearer than that only that the air is clear. Much cheaper than rendering; for tests of
// navigation.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapper/voxel_map.hpp"
#include "nav/cell_grid.hpp"
#include "tests/support/kinematic_robot.hpp"

namespace g3d::tests {

class VoxelFloor {
 public:
  explicit VoxelFloor(const Box& extent, float resolution_m = 0.05F);

  /// Takes over what the robot's camera sees from where it is. What is seen through is forgotten to be a wall.
  void look(const KinematicRobot& robot);
  [[nodiscard]] const mapper::VoxelMap& map() const { return map_; }
  /// Of the last look().
  [[nodiscard]] std::span<const std::uint32_t> changed_slots() const { return changed_slots_; }
  /// Cells of which anything is known, as a share of `of`.
  [[nodiscard]] double coverage(const nav::CellGrid<nav::CellState>& of) const;
  [[nodiscard]] const nav::CellGrid<std::uint8_t>& seen() const { return seen_; }

 private:
  void set(nav::Cell c, std::uint8_t flags);
  void write(nav::Cell c);

  mapper::VoxelMap map_;
  nav::CellGrid<std::uint8_t> seen_;  ///< air, floor, wall
  std::vector<nav::Cell> changed_;
  std::vector<std::uint32_t> changed_slots_;
};

}  // namespace g3d::tests
