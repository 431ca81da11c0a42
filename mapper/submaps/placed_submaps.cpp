// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/placed_submaps.hpp"

#include <algorithm>
#include <cassert>

#include "mapper/block_source.hpp"

namespace g3d::mapper::submaps {

std::unique_ptr<PlacedSubmaps::Placed> PlacedSubmaps::place(const VoxelMap& voxels,
                                                            const hal::Pose& T_world_stored) const {
  auto placed = std::make_unique<Placed>(Placed{MapSampler(voxels, T_world_stored, grid_, hal::Pose{}), {}});
  placed->sampler.add_target_keys(placed->keys);
  sort_and_drop_repeats(placed->keys);
  return placed;
}

void PlacedSubmaps::add(const VoxelMap& voxels, const hal::Pose& T_world_stored) {
  placed_.push_back(place(voxels, T_world_stored));
}

void PlacedSubmaps::join(std::size_t submap, const VoxelMap& voxels, const hal::Pose& T_world_stored) {
  placed_[submap] = place(voxels, T_world_stored);
  placed_.erase(placed_.begin() + static_cast<std::ptrdiff_t>(submap) + 1);
}

std::vector<BlockKey> PlacedSubmaps::keys() const {
  std::vector<BlockKey> all;
  for (const auto& placed : placed_) all.insert(all.end(), placed->keys.begin(), placed->keys.end());
  sort_and_drop_repeats(all);
  return all;
}

bool PlacedSubmaps::read_block(BlockKey key, BlockValues& out) {
  out.fill(kUnknownRgbo);
  for (std::size_t i = placed_.size(); i-- > 0;) {
    const auto& keys = placed_[i]->keys;
    if (!std::binary_search(keys.begin(), keys.end(), key)) continue;
    if (placed_[i]->sampler.sample_unknown(key, out)) break;
  }
  return is_known(out);
}

std::unique_ptr<VoxelMap> PlacedSubmaps::whole() {
  const std::vector<BlockKey> all = keys();
  const auto count = static_cast<std::uint32_t>(std::max<std::size_t>(all.size(), 1));
  auto map = std::make_unique<VoxelMap>(grid_, MapCapacity{count, count, count * kBricksPerBlock});
  BlockValues values;
  for (const BlockKey key : all) {
    if (!read_block(key, values)) continue;
    [[maybe_unused]] const bool fits = map->write_block(key, values);
    assert(fits);
  }
  return map;
}

std::uint64_t PlacedSubmaps::memory_bytes() const {
  std::uint64_t bytes = 0;
  for (const auto& placed : placed_) bytes += placed->keys.size() * sizeof(BlockKey);
  return bytes;
}

}  // namespace g3d::mapper::submaps
