// SPDX-License-Identifier: Apache-2.0
#include "nav/column_evidence.hpp"

#include <algorithm>

namespace g3d::nav {

using mapper::kBlockSide_cells;
using mapper::State;

ColumnReader::ColumnReader(const GroundLayers& layers, int voxels_per_cell, std::uint8_t speckle_level)
    : cells_per_block_(kBlockSide_cells / voxels_per_cell) {
  tables_.first_block_z = layers.first() / kBlockSide_cells;
  tables_.last_block_z =
      std::min(layers.last() / kBlockSide_cells, tables_.first_block_z + mapper::kMostColumnLayers - 1);
  tables_.voxels_per_cell = voxels_per_cell;
  const auto set_meaning = [&](Layer kind, std::size_t level, State state, Evidence if_free, Evidence if_occupied) {
    tables_.bits[static_cast<std::size_t>(kind)][level] = state == State::free       ? if_free
                                                          : state == State::occupied ? if_occupied
                                                                                     : Evidence{0};
  };
  for (std::uint8_t level = 0; level < mapper::kColumnLevels; ++level) {
    const State state = mapper::state_of_level(level);
    const Evidence hit = level > speckle_level ? kHitOnce | kObstacle : kHitOnce;
    set_meaning(Layer::drop, level, state, kDropSeen, 0);
    set_meaning(Layer::floor, level, state, 0, kFloorSeen);
    set_meaning(Layer::low, level, state, kAirSeen | kLowSeen, hit);
    set_meaning(Layer::air, level, state, kAirSeen, hit);
    set_meaning(Layer::upper_band, level, state, 0, hit);
  }
  for (std::int32_t block_z = first_block_z(); block_z <= last_block_z(); ++block_z) {
    for (std::int32_t z = 0; z < kBlockSide_cells; ++z) {
      const std::int32_t layer = block_z * kBlockSide_cells + z;
      const Layer kind = layers.drop.contains(layer)    ? Layer::drop
                         : layers.floor.contains(layer) ? Layer::floor
                         : layers.low.contains(layer)   ? Layer::low
                         : layers.air.contains(layer)   ? Layer::air
                         : layers.band.contains(layer)  ? Layer::upper_band
                                                        : Layer::none;
      tables_.kinds[block_z - first_block_z()][z] = static_cast<std::uint8_t>(kind);
    }
  }
  for (std::size_t place = 0; place < mapper::kBlockVoxels; ++place) {
    const mapper::VoxelIndex v = mapper::decode(place);
    cell_of_place_[place] = static_cast<std::uint8_t>(v.y / voxels_per_cell * cells_per_block_ + v.x / voxels_per_cell);
    z_of_place_[place] = static_cast<std::uint8_t>(v.z);
  }
}

void ColumnReader::read(const mapper::VoxelMap& map, std::uint32_t slot, std::int32_t block_z, Cells cells) const {
  cells = cells.first(static_cast<std::size_t>(cells_per_block_) * static_cast<std::size_t>(cells_per_block_));
  const auto& kinds = tables_.kinds[block_z - first_block_z()];
  Meanings meanings{};
  for (std::size_t z = 0; z < meanings.size(); ++z) meanings[z] = tables_.bits[kinds[z]];
  const mapper::BlockHeader& header = map.header(slot);
  if (header.plane == mapper::kNoSlot) {
    read_uniform(header.uniform_level, meanings, cells);
  } else {
    read_plane(map.plane(header.plane), meanings, cells);
  }
}

void ColumnReader::read_uniform(std::uint8_t level, const Meanings& meanings, Cells cells) const {
  Evidence all = 0;
  for (const Evidence* meaning : meanings) {
    const Evidence one = meaning[level & mapper::kLevelMask];
    all = together(all, tables_.voxels_per_cell > 1 ? together(one, one) : one);
  }
  std::fill(cells.begin(), cells.end(), all);
}

void ColumnReader::read_plane(const mapper::LevelPlane& levels, const Meanings& meanings, Cells cells) const {
  std::array<Evidence, kBlockSide_cells * kBlockSide_cells> sums{};
  for (std::size_t place = 0; place < levels.size(); ++place) {
    Evidence& cell = sums[cell_of_place_[place]];
    cell = together(cell, meanings[z_of_place_[place]][levels[place] & mapper::kLevelMask]);
  }
  std::copy_n(sums.begin(), cells.size(), cells.begin());
}

}  // namespace g3d::nav
