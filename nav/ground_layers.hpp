// SPDX-License-Identifier: Apache-2.0
// Which layers of voxels mean floor, obstacle or drop-off to a body that stands on z = 0, and how large the cells are.
#pragma once

#include <cstdint>

#include "mapper/grid.hpp"

namespace g3d::nav {

struct GroundHeights {
  double step_m = 0.015;          ///< the robot climbs no higher
  double body_height_m = 0.6;     ///< it drives under what is higher
  double presume_below_m = 0.45;  ///< air seen below this (a little under the camera) lets one presume a free floor
  double low_m = 0.10;            ///< whoever looks through this low sees the floor, too, unless there is none
  double drop_m = 0.05;           ///< seen through this far below floor level: a drop-off (Kobuki: cliffs above 5 cm)
  double drop_depth_m = 0.4;      ///< how far down to look for it
};

/// A range of voxel layers, both ends included; empty if last < first.
struct LayerRange {
  std::int32_t first = 0;
  std::int32_t last = -1;
  [[nodiscard]] bool contains(std::int32_t k) const { return k >= first && k <= last; }
};

struct GroundLayers {
  LayerRange floor;  ///< around z = 0: at least 2 cm below, and up to the first layer of the band
  LayerRange band;   ///< layers that lie wholly above a step and reach into the body
  LayerRange air;    ///< the part of the band in which free voxels count
  LayerRange low;    ///< the lowest part of the air
  LayerRange drop;   ///< layers wholly below the drop
  [[nodiscard]] std::int32_t first() const { return drop.last >= drop.first ? drop.first : floor.first; }
  [[nodiscard]] std::int32_t last() const { return band.last; }
};

[[nodiscard]] GroundLayers ground_layers(const mapper::Grid& grid, const GroundHeights& heights);

/// 1, 2, 4 or 8: which makes the cell's side come nearest to 5 cm. A block of 8 voxels holds whole cells.
[[nodiscard]] int voxels_per_ground_cell(const mapper::Grid& grid);

}  // namespace g3d::nav
