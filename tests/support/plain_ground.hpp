// SPDX-License-Identifier: Apache-2.0
// The ground map's rules in their plainest form, voxel by voxel and from scratch, to compare it with.
#pragma once

#include "mapper/voxel_map.hpp"
#include "nav/ground_map.hpp"

namespace g3d::tests {

/// Without marks. `like` says which cells.
[[nodiscard]] nav::CellGrid<nav::CellState> plain_ground(const mapper::VoxelMap& map,
                                                         const nav::CellGrid<nav::CellState>& like,
                                                         const nav::GroundMapConfig& config);

}  // namespace g3d::tests
