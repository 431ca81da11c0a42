// SPDX-License-Identifier: Apache-2.0
// M-codes (thesis equations 19-25): the bits of three 16-bit coordinates interleaved, x lowest, 48 bits in a uint64_t.
// `M >> 3k` is the ancestor k levels up; `M >> 9` names a block of 8x8x8 voxels and `M & 511` the place in it.
#pragma once

#include <cstdint>

#include "mapper/grid.hpp"

namespace g3d::mapper {

using MCode = std::uint64_t;
using BlockKey = std::uint64_t;  ///< M >> 9, 39 bits

inline constexpr int kBlockShift = 9;
inline constexpr int kBlockSide_cells = 8;
inline constexpr int kBlockVoxels = 512;
inline constexpr std::uint64_t kPlaceMask = kBlockVoxels - 1;

/// Spreads the low 16 bits so that bit i lands on bit 3i.
[[nodiscard]] constexpr std::uint64_t spread_bits(std::uint64_t v) {
  v &= 0xFFFFU;
  v = (v | (v << 16)) & 0x0000FF0000FFULL;
  v = (v | (v << 8)) & 0x00F00F00F00FULL;
  v = (v | (v << 4)) & 0x0C30C30C30C3ULL;
  v = (v | (v << 2)) & 0x249249249249ULL;
  return v;
}

/// Inverse of spread_bits: collects bits 0, 3, 6, ... 45.
[[nodiscard]] constexpr std::uint32_t collect_bits(std::uint64_t v) {
  v &= 0x249249249249ULL;
  v = (v | (v >> 2)) & 0x0C30C30C30C3ULL;
  v = (v | (v >> 4)) & 0x00F00F00F00FULL;
  v = (v | (v >> 8)) & 0x0000FF0000FFULL;
  v = (v | (v >> 16)) & 0xFFFFULL;
  return static_cast<std::uint32_t>(v);
}

[[nodiscard]] constexpr MCode encode(const VoxelIndex& v) {
  return spread_bits(static_cast<std::uint64_t>(v.x)) | (spread_bits(static_cast<std::uint64_t>(v.y)) << 1) |
         (spread_bits(static_cast<std::uint64_t>(v.z)) << 2);
}

[[nodiscard]] constexpr VoxelIndex decode(MCode m) {
  return {static_cast<std::int32_t>(collect_bits(m)), static_cast<std::int32_t>(collect_bits(m >> 1)),
          static_cast<std::int32_t>(collect_bits(m >> 2))};
}

/// Octal digit of the path from the root: depth 1 is the root's child, 16 the voxel itself.
[[nodiscard]] constexpr int octal_digit(MCode m, int depth) {
  return static_cast<int>((m >> (3 * (kAxisBits - depth))) & 7U);
}

/// Lowest voxel of a block.
[[nodiscard]] constexpr VoxelIndex block_origin(BlockKey key) { return decode(key << kBlockShift); }
[[nodiscard]] constexpr BlockKey block_of(const VoxelIndex& v) { return encode(v) >> kBlockShift; }

/// M & 511 of a voxel, whose coordinates are 0..7, in 32 bits.
[[nodiscard]] constexpr std::uint32_t spread_three(std::uint32_t v) { return (v & 1U) | (v & 2U) << 2 | (v & 4U) << 4; }
[[nodiscard]] constexpr std::uint32_t place_at(std::int32_t x, std::int32_t y, std::int32_t z) {
  return spread_three(static_cast<std::uint32_t>(x)) | spread_three(static_cast<std::uint32_t>(y)) << 1 |
         spread_three(static_cast<std::uint32_t>(z)) << 2;
}

}  // namespace g3d::mapper
