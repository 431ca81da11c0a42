// SPDX-License-Identifier: Apache-2.0
// Walls of a map that is turned against the grid it is looked up from. A thin wall may pass between the centres of
// voxels, and would have holes there that it does not have in its own map. So every step from a centre to the next that
// goes through an occupied voxel, and that has no way round by a voxel beside it, is closed: of its two ends the nearer
// to what is in the way becomes occupied. What the map keeps apart, the grid keeps apart, face by face, and no more is
// added than that takes.
//
// A function of the map and the place alone: neighbouring blocks agree without knowing of each other. Twin of nothing;
// the order of the loops does not count. Thread: while nobody writes the map.
#pragma once

#include <array>

#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

/// Centres of a block's voxels and of those beside it, in voxels of the map from the corner of its grid's voxel 32768:
/// a centre at u lies in voxel 32767 + ceil(u). In order of x, then y, then z.
inline constexpr int kCentresSide = kBlockSide_cells + 2;
using Centres = std::array<std::array<double, 3>, kCentresSide * kCentresSide * kCentresSide>;

/// `values`: what the map says at the block's own centres, stored codes. The map's voxels are not smaller than the
/// grid's.
void close_walls(const VoxelMap& map, const Centres& centres, BlockValues& values);

/// How far from what is occupied a voxel can be that is closed for its sake, in voxels of the grid, on each axis.
inline constexpr int kClosingReach_cells = 1;

}  // namespace g3d::mapper
