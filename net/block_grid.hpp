// SPDX-License-Identifier: Apache-2.0
// The voxels of a block in rows, with a border all around, for whoever looks at those that come before one: z slowest,
// so that a half of a block (M & 511 below 256, which is z below 4) is the first or the last half of the order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "mapper/morton.hpp"
#include "mapper/voxel_map.hpp"
#include "net/block_part.hpp"

namespace g3d::net {

/// Stands for a level where there is no voxel of this part. Even, as nearly all levels are.
inline constexpr std::uint8_t kNoLevel = mapper::kMaxLevel + 2;

inline constexpr int kRow = mapper::kBlockSide_cells + 2;
inline constexpr int kLayer = kRow * kRow;
inline constexpr std::size_t kGridPlaces = std::size_t{kLayer} * (mapper::kBlockSide_cells + 1) + 2 * kRow;

/// Place of a voxel in such a grid. Neighbours are at -1, -kRow and -kLayer.
[[nodiscard]] constexpr std::size_t grid_place(int x, int y, int z) {
  return static_cast<std::size_t>(std::ptrdiff_t{kLayer} * (z + 1) + std::ptrdiff_t{kRow} * (y + 1) + x + 1);
}

struct GridOrder {
  std::array<std::uint16_t, mapper::kBlockVoxels> grid{};   ///< in order: place in the grid
  std::array<std::uint16_t, mapper::kBlockVoxels> block{};  ///< in order: M & 511
};
constexpr GridOrder make_grid_order() {
  GridOrder order;
  std::size_t at = 0;
  for (int z = 0; z < mapper::kBlockSide_cells; ++z) {
    for (int y = 0; y < mapper::kBlockSide_cells; ++y) {
      for (int x = 0; x < mapper::kBlockSide_cells; ++x, ++at) {
        order.grid[at] = static_cast<std::uint16_t>(grid_place(x, y, z));
        order.block[at] = static_cast<std::uint16_t>(mapper::place_at(x, y, z));
      }
    }
  }
  return order;
}
inline constexpr GridOrder kGridOrder = make_grid_order();

struct PlaceRange {
  std::size_t begin;
  std::size_t end;
  [[nodiscard]] constexpr std::size_t count() const { return end - begin; }
};
/// Of M & 511, and of the order of rows as well.
[[nodiscard]] constexpr PlaceRange places_of(Part part) {
  constexpr std::size_t kHalf = mapper::kBlockVoxels / 2;
  return {part == Part::high_half ? kHalf : 0, part == Part::low_half ? kHalf : std::size_t{mapper::kBlockVoxels}};
}

}  // namespace g3d::net
