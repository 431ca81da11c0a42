// SPDX-License-Identifier: Apache-2.0
// The voxel map seen from above: one cell per column of voxels. Occupied if any voxel of the height band is occupied,
// else free if any is known free, else unknown.
#pragma once

#include <cstdint>
#include <vector>

#include "mapper/voxel_map.hpp"

namespace g3d::nav {

struct HeightBand {
  float low_m = 0.10F;   ///< below: floor and thresholds that the robot rolls over
  float high_m = 1.20F;  ///< above: what it drives under
};

/// Cell (column, row) covers [origin + column * resolution, + resolution] in x, the same with row in y: row 0 is lowest
/// y.
struct GroundGrid {
  float resolution_m = 0.05F;
  double origin_x_m = 0;  ///< lower left corner of cell (0, 0), in the map frame
  double origin_y_m = 0;
  int columns = 0;
  int rows = 0;
  std::vector<mapper::State> cells;  ///< row * columns + column

  [[nodiscard]] mapper::State at(int column, int row) const {
    if (column < 0 || row < 0 || column >= columns || row >= rows) return mapper::State::unknown;
    return cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)];
  }
};

/// What an image file may hold (map_server's pgm); a robot's day is far below.
inline constexpr int kMaxGroundSide_cells = 16384;

/// Voxels whose centre lies in the band count. The grid is the smallest that holds all of them; empty if there are
/// none. A map that strays farther than kMaxGroundSide_cells is cut there, around the median of its blocks.
[[nodiscard]] GroundGrid project_to_ground(const mapper::VoxelMap& map, const HeightBand& band = {});

}  // namespace g3d::nav
