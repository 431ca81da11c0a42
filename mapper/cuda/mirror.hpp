// SPDX-License-Identifier: Apache-2.0
// Single blocks between parcels and the host's map. Both twins give a block the same form, so bytes are copied as they
// are.
#pragma once

#include <cstdint>

#include "mapper/cuda/memory.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper::cuda {

struct Taken {
  std::uint32_t slot;  ///< kNoSlot: there was no room for the block or its levels, and it is as before
  bool complete;       ///< else it has at most the levels, and where there was no room for colours no colour
};

/// The host's block becomes what parcel `index` says.
Taken take_parcel(VoxelMap& map, const Parcels& parcels, std::uint32_t index, std::uint32_t frame_number);

/// Parcel `index` says what the host's map has under this key. False: there is no such block.
bool make_parcel(const VoxelMap& map, BlockKey key, const Parcels& parcels, std::uint32_t index);

}  // namespace g3d::mapper::cuda
