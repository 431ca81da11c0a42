// SPDX-License-Identifier: Apache-2.0
// What the voxels of one block say about the floor cells below it, and what the blocks of a column say together.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "mapper/column_bits.hpp"
#include "mapper/voxel_map.hpp"
#include "nav/ground_layers.hpp"

namespace g3d::nav {

/// Bits, as many as apply.
using Evidence = std::uint8_t;
inline constexpr Evidence kFloorSeen = 1;  ///< an occupied voxel of the floor layers
inline constexpr Evidence kAirSeen = 2;    ///< a free voxel of the air layers
inline constexpr Evidence kDropSeen = 4;   ///< a free voxel of the drop layers (and no floor: see settled())
inline constexpr Evidence kHitOnce = 8;    ///< an occupied voxel of the band
inline constexpr Evidence kObstacle = 16;  ///< two of them, or one that was hit more than once
inline constexpr Evidence kLowSeen = 32;   ///< a free voxel of the low layers

/// Of voxels, or blocks, one above the other. Whatever is hit twice in the band is an obstacle.
[[nodiscard]] constexpr Evidence together(Evidence a, Evidence b) {
  static_assert(kHitOnce == mapper::kCountedBit && kObstacle == kHitOnce << 1);
  return mapper::joined_bits(a, b);
}
/// Of a whole column: where there is floor there is no drop.
[[nodiscard]] constexpr Evidence settled(Evidence column) {
  return static_cast<Evidence>((column & kFloorSeen) != 0 ? column & ~kDropSeen : column);
}

class ColumnReader {
 public:
  ColumnReader(const GroundLayers& layers, int voxels_per_cell, std::uint8_t speckle_level);

  [[nodiscard]] int cells_per_block() const { return cells_per_block_; }
  /// Block layers (voxel layer / 8) that matter, both ends included.
  [[nodiscard]] std::int32_t first_block_z() const { return tables_.first_block_z; }
  [[nodiscard]] std::int32_t last_block_z() const { return tables_.last_block_z; }
  /// The same for a mapper that reads blocks itself.
  [[nodiscard]] const mapper::ColumnTables& tables() const { return tables_; }

  /// `cells[y * cells_per_block + x]`; the others are not touched.
  using Cells = std::span<Evidence>;
  /// What the block of this slot says, which lies in block layer `block_z`.
  void read(const mapper::VoxelMap& map, std::uint32_t slot, std::int32_t block_z, Cells cells) const;

 private:
  enum class Layer : std::uint8_t { none, drop, floor, low, air, upper_band };
  /// What a level means in each of the eight layers of a block.
  using Meanings = std::array<const Evidence*, mapper::kBlockSide_cells>;

  void read_uniform(std::uint8_t level, const Meanings& meanings, Cells cells) const;
  void read_plane(const mapper::LevelPlane& levels, const Meanings& meanings, Cells cells) const;

  int cells_per_block_;
  mapper::ColumnTables tables_{};
  std::array<std::uint8_t, mapper::kBlockVoxels> cell_of_place_{};  ///< which cell a voxel stands on
  std::array<std::uint8_t, mapper::kBlockVoxels> z_of_place_{};
};

}  // namespace g3d::nav
