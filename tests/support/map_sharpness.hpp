// SPDX-License-Identifier: Apache-2.0
// How much of one map's surface is where another map has it, give or take one voxel.
#pragma once

#include "mapper/voxel_map.hpp"

namespace g3d::test {

/// Share of the occupied voxels of `map` that have an occupied voxel of `other` among their 27 nearest. 1 for an empty
/// map.
[[nodiscard]] double share_near(const mapper::VoxelMap& map, const mapper::VoxelMap& other);

}  // namespace g3d::test
