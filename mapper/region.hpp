// SPDX-License-Identifier: Apache-2.0
// Regions: cubes of 8x8x8 blocks (64 voxels a side), the unit in which the map moves between memory and disk.
#pragma once

#include <algorithm>
#include <cstdint>

#include "mapper/morton.hpp"

namespace g3d::mapper {

using RegionKey = std::uint64_t;  ///< M >> 18, 30 bits

inline constexpr int kRegionShift = 9;  ///< from block key to region key
inline constexpr int kRegionBlocks = 512;
inline constexpr int kRegionSide_cells = 64;

[[nodiscard]] constexpr RegionKey region_of(BlockKey key) { return key >> kRegionShift; }
[[nodiscard]] constexpr RegionKey region_of(const VoxelIndex& v) { return region_of(block_of(v)); }
[[nodiscard]] constexpr BlockKey first_block(RegionKey region) { return region << kRegionShift; }
/// Lowest voxel of a region.
[[nodiscard]] constexpr VoxelIndex region_origin(RegionKey region) { return block_origin(first_block(region)); }

/// The regions that a box of voxels touches.
struct RegionBox {
  VoxelIndex low;   ///< regions along each axis
  VoxelIndex high;  ///< as well, inclusive

  RegionBox() = default;
  constexpr RegionBox(const VoxelIndex& lowest, const VoxelIndex& highest) : low(along(lowest)), high(along(highest)) {}
  [[nodiscard]] constexpr bool holds(RegionKey region) const {
    const VoxelIndex v = decode(region);
    return v.x >= low.x && v.x <= high.x && v.y >= low.y && v.y <= high.y && v.z >= low.z && v.z <= high.z;
  }
  template <typename Visit>
  void for_each(Visit&& visit) const {
    for (std::int32_t z = low.z; z <= high.z; ++z) {
      for (std::int32_t y = low.y; y <= high.y; ++y) {
        for (std::int32_t x = low.x; x <= high.x; ++x) visit(static_cast<RegionKey>(encode({x, y, z})));
      }
    }
  }

 private:
  [[nodiscard]] static constexpr VoxelIndex along(const VoxelIndex& v) {
    return {v.x / kRegionSide_cells, v.y / kRegionSide_cells, v.z / kRegionSide_cells};
  }
};

/// Square of the distance in voxels from `v` to the nearest voxel of the region; 0 inside. Integers, so that every
/// machine decides alike.
[[nodiscard]] constexpr std::int64_t squared_distance_cells(RegionKey region, const VoxelIndex& v) {
  const VoxelIndex low = region_origin(region);
  const auto gap = [](std::int32_t x, std::int32_t first) {
    return std::int64_t{std::max({first - x, x - (first + kRegionSide_cells - 1), 0})};
  };
  const std::int64_t dx = gap(v.x, low.x);
  const std::int64_t dy = gap(v.y, low.y);
  const std::int64_t dz = gap(v.z, low.z);
  return dx * dx + dy * dy + dz * dz;
}

}  // namespace g3d::mapper
