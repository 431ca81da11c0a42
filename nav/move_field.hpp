// SPDX-License-Identifier: Apache-2.0
// The map was corrected: where on the floor has a place gone to? What a robot knows of a place without its voxels (a
// touch, a step, floor that it has looked at) moves as the robot's own way near it does, the newest stretch of it
// first. One thread; memory is provided at construction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/messages.hpp"
#include "hal/twist.hpp"
#include "mapper/submaps/chain_move.hpp"
#include "nav/cell_grid.hpp"

namespace g3d::nav {

/// The centre of the body at a time, world frame.
struct Trodden {
  hal::TimeNs at_ns = 0;
  double x_m = 0.0;
  double y_m = 0.0;
};

/// The same place after its surroundings have moved.
[[nodiscard]] Trodden moved(const Trodden& place, const hal::PlanarPose& T_now_before);

class MoveField {
 public:
  static constexpr double kPatch_m = 1.0;
  /// For grids of this geometry.
  explicit MoveField(const CellGrid<CellState>& like);

  /// `way`: where the body was before the correction, oldest first.
  void compute(std::span<const Trodden> way, const mapper::submaps::ChainMove& move);
  /// Where a place of before has gone to.
  [[nodiscard]] Trodden moved(const Trodden& place) const;
  /// A grid of before, where it is now; zero where nothing was, and farther than kReach_patches from the way.
  /// `scratch`: as many cells.
  void resample(CellGrid<std::uint8_t>& grid, std::vector<std::uint8_t>& scratch) const;
  static constexpr int kReach_patches = 6;

 private:
  struct Move {
    bool is_known = false;
    hal::PlanarPose T_now_before;
  };
  [[nodiscard]] Cell patch_of(double x_m, double y_m) const;

  CellGrid<Move> patches_;
  std::vector<std::uint32_t> front_;
};

}  // namespace g3d::nav
