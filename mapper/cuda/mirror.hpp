// SPDX-License-Identifier: Apache-2.0
// Single blocks between parcels and the host's map. Both twins give a block the same form, so bytes are copied as they
// are.
#pragma once

#include <cstdint>

#include "mapper/cuda/memory.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper::cuda {

/// The host's block becomes what parcel `index` says. Its slot, kNoSlot if a pool is full (the block is then as before,
/// or has its levels without its colours).
std::uint32_t take_parcel(VoxelMap& map, const Parcels& parcels, std::uint32_t index, std::uint32_t frame_number);

/// Parcel `index` says what the host's map has under this key: a block, or that there is none.
void make_parcel(const VoxelMap& map, BlockKey key, const Parcels& parcels, std::uint32_t index);

}  // namespace g3d::mapper::cuda
