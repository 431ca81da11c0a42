// SPDX-License-Identifier: Apache-2.0
// BLAKE2b-256 over the known blocks in ascending order of key: the key as little-endian u64, then 512 little-endian u32
// RGBO-codes with the spare bits zero, and RGB zero unless occupied. Two maps are equal if and only if their hashes
// are.
#pragma once

#include <string>

#include "mapper/block_source.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

/// 64 hexadecimal digits.
[[nodiscard]] std::string map_hash(const VoxelMap& map);
/// Paged-out blocks included, a region at a time.
[[nodiscard]] std::string map_hash(const BlockSource& source);

}  // namespace g3d::mapper
