// SPDX-License-Identifier: Apache-2.0
// What the voxels of a block say about the floor cells below it, in eight bits whose meaning the asker alone knows (see
// nav/column_evidence.hpp): a table from layer and level to bits, and the one rule for putting them together. Both
// twins compile this source.
#pragma once

#include <cstdint>
#include <span>

#include "mapper/morton.hpp"
#include "mapper/rgbo.hpp"

namespace g3d::mapper {

/// Set in two voxels of a column, this bit sets the next higher one.
inline constexpr std::uint8_t kCountedBit = 8;
[[nodiscard]] constexpr std::uint8_t joined_bits(std::uint32_t a, std::uint32_t b) {
  return static_cast<std::uint8_t>(a | b | (a & b & kCountedBit) << 1);
}

inline constexpr int kMostColumnLayers = 64;  ///< of blocks
inline constexpr int kLayerKinds = 6;
inline constexpr int kColumnLevels = kLevelMask + 1;

/// Plain data: it goes to a card as it is.
struct ColumnTables {
  std::int32_t first_block_z;    ///< block layers (voxel layer / 8) that matter, both ends included
  std::int32_t last_block_z;     ///< at most kMostColumnLayers of them
  std::int32_t voxels_per_cell;  ///< 1, 2, 4 or 8
  std::uint8_t kinds[kMostColumnLayers][kBlockSide_cells];  ///< [block layer - first][z in it]: row of `bits`
  std::uint8_t bits[kLayerKinds][kColumnLevels];
};

/// Cells of a block.
[[nodiscard]] constexpr std::uint32_t cells_of(const ColumnTables& tables) {
  const auto side = static_cast<std::uint32_t>(kBlockSide_cells / tables.voxels_per_cell);
  return side * side;
}

/// Index of the block's layer in the tables, -1 if it does not matter.
[[nodiscard]] constexpr std::int32_t column_layer(const ColumnTables& tables, BlockKey key) {
  const auto z = static_cast<std::int32_t>(collect_bits(key >> 2));
  return z < tables.first_block_z || z > tables.last_block_z ? -1 : z - tables.first_block_z;
}

/// Of blocks that a frame changed and whose layer matters; the cells of block i are cells[i * cells_per_block] and
/// following, y * side + x.
struct ChangedColumns {
  std::span<const BlockKey> keys;
  const std::uint8_t* cells = nullptr;
  std::uint32_t cells_per_block = 0;  ///< 0: nobody was asked, or there were no answers; look at the map instead
};

}  // namespace g3d::mapper
