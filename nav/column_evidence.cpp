// SPDX-License-Identifier: Apache-2.0
#include "nav/column_evidence.hpp"

#include <algorithm>

namespace g3d::nav {
namespace {

using mapper::kBlockSide_cells;
using mapper::State;

// Whatever is hit twice in the band is an obstacle: the carry of one bit into the next.
static_assert(kObstacle == kHitOnce << 1);
Evidence add(Evidence sum, Evidence more) { return static_cast<Evidence>(sum | more | ((sum & more & kHitOnce) << 1)); }

}  // namespace

ColumnReader::ColumnReader(const GroundLayers& layers, int voxels_per_cell, std::uint8_t speckle_level)
    : voxels_per_cell_(voxels_per_cell),
      cells_per_block_(kBlockSide_cells / voxels_per_cell),
      first_block_z_(layers.first() / kBlockSide_cells),
      last_block_z_(std::min(layers.last() / kBlockSide_cells, first_block_z_ + kMaxBlocks - 1)) {
  const auto set_meaning = [&](Layer kind, std::size_t level, State state, Evidence if_free, Evidence if_occupied) {
    meaning_[static_cast<std::size_t>(kind)][level] = state == State::free       ? if_free
                                                      : state == State::occupied ? if_occupied
                                                                                 : Evidence{0};
  };
  for (std::uint8_t level = 0; level < kLevels; ++level) {
    const State state = mapper::state_of_level(level);
    const Evidence hit = level > speckle_level ? kHitOnce | kObstacle : kHitOnce;
    set_meaning(Layer::drop, level, state, kDropSeen, 0);
    set_meaning(Layer::floor, level, state, 0, kFloorSeen);
    set_meaning(Layer::low, level, state, kAirSeen | kLowSeen, hit);
    set_meaning(Layer::air, level, state, kAirSeen, hit);
    set_meaning(Layer::upper_band, level, state, 0, hit);
  }
  for (std::int32_t block_z = first_block_z_; block_z <= last_block_z_; ++block_z) {
    for (std::int32_t z = 0; z < kBlockSide_cells; ++z) {
      const std::int32_t layer = block_z * kBlockSide_cells + z;
      kinds_[static_cast<std::size_t>(block_z - first_block_z_)][static_cast<std::size_t>(z)] =
          layers.drop.contains(layer)    ? Layer::drop
          : layers.floor.contains(layer) ? Layer::floor
          : layers.low.contains(layer)   ? Layer::low
          : layers.air.contains(layer)   ? Layer::air
          : layers.band.contains(layer)  ? Layer::upper_band
                                         : Layer::none;
    }
  }
  for (std::size_t place = 0; place < mapper::kBlockVoxels; ++place) {
    const mapper::VoxelIndex v = mapper::decode(place);
    cell_of_place_[place] = static_cast<std::uint8_t>(v.y / voxels_per_cell * cells_per_block_ + v.x / voxels_per_cell);
    z_of_place_[place] = static_cast<std::uint8_t>(v.z);
  }
}

void ColumnReader::read(const mapper::VoxelMap& map, std::int32_t block_x, std::int32_t block_y, Cells& cells) const {
  cells.fill(0);
  for (std::int32_t block_z = first_block_z_; block_z <= last_block_z_; ++block_z) {
    const std::uint32_t slot = map.find(mapper::encode({block_x, block_y, block_z}));
    if (slot == mapper::kNoSlot) continue;
    const auto& kinds = kinds_[static_cast<std::size_t>(block_z - first_block_z_)];
    Meanings meanings{};
    for (std::size_t z = 0; z < kinds.size(); ++z) meanings[z] = meaning_[static_cast<std::size_t>(kinds[z])].data();
    const mapper::BlockHeader& header = map.header(slot);
    if (header.plane == mapper::kNoSlot) {
      read_uniform(header.uniform_level, meanings, cells);
    } else {
      read_plane(map.plane(header.plane), meanings, cells);
    }
  }
  for (Evidence& cell : cells) {
    if ((cell & kFloorSeen) != 0) cell &= static_cast<Evidence>(~kDropSeen);
  }
}

void ColumnReader::read_uniform(std::uint8_t level, const Meanings& meanings, Cells& cells) const {
  Evidence all = 0;
  for (const Evidence* meaning : meanings) {
    const Evidence one = meaning[level & mapper::kLevelMask];
    all = add(all, voxels_per_cell_ > 1 ? add(one, one) : one);
  }
  for (Evidence& cell : cells) cell = add(cell, all);
}

void ColumnReader::read_plane(const mapper::LevelPlane& levels, const Meanings& meanings, Cells& cells) const {
  for (std::size_t place = 0; place < levels.size(); ++place) {
    Evidence& cell = cells[cell_of_place_[place]];
    cell = add(cell, meanings[z_of_place_[place]][levels[place] & mapper::kLevelMask]);
  }
}

}  // namespace g3d::nav
