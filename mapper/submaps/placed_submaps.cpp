// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/placed_submaps.hpp"

#include <algorithm>
#include <cassert>
#include <limits>

#include "mapper/block_source.hpp"

namespace g3d::mapper::submaps {

std::unique_ptr<PlacedSubmaps::Placed> PlacedSubmaps::place(ShelvedContents& contents,
                                                            const hal::Pose& T_world_stored) const {
  auto placed = std::make_unique<Placed>(
      Placed{MapSampler(contents.grid(), T_world_stored, grid_, hal::Pose{}), &contents, {}, {}});
  placed->sampler.add_target_keys(contents.keys(), placed->keys);
  sort_and_drop_repeats(placed->keys);
  for (const BlockKey key : placed->keys) {
    if (placed->regions.empty() || placed->regions.back() != region_of(key)) placed->regions.push_back(region_of(key));
  }
  return placed;
}

void PlacedSubmaps::add(ShelvedContents& contents, const hal::Pose& T_world_stored) {
  placed_.push_back(place(contents, T_world_stored));
}

void PlacedSubmaps::join(std::size_t submap, ShelvedContents& contents, const hal::Pose& T_world_stored) {
  placed_[submap] = place(contents, T_world_stored);
  placed_.erase(placed_.begin() + static_cast<std::ptrdiff_t>(submap) + 1);
}

std::vector<BlockKey> PlacedSubmaps::keys() const {
  std::vector<BlockKey> all;
  for (const auto& placed : placed_) all.insert(all.end(), placed->keys.begin(), placed->keys.end());
  sort_and_drop_repeats(all);
  return all;
}

std::vector<BlockKey> PlacedSubmaps::keys_in(RegionKey region) const {
  std::vector<BlockKey> all;
  for (const auto& placed : placed_) {
    const auto first = std::lower_bound(placed->keys.begin(), placed->keys.end(), first_block(region));
    const auto end = std::lower_bound(first, placed->keys.end(), first_block(region + 1));
    all.insert(all.end(), first, end);
  }
  sort_and_drop_repeats(all);
  return all;
}

std::vector<RegionKey> PlacedSubmaps::regions() const {
  std::vector<RegionKey> all;
  for (const auto& placed : placed_) all.insert(all.end(), placed->regions.begin(), placed->regions.end());
  sort_and_drop_repeats(all);
  return all;
}

std::int64_t PlacedSubmaps::squared_distance_cells(std::size_t submap, const VoxelIndex& v) const {
  std::int64_t nearest = std::numeric_limits<std::int64_t>::max();
  for (const RegionKey region : placed_[submap]->regions) {
    nearest = std::min(nearest, mapper::squared_distance_cells(region, v));
  }
  return nearest;
}

bool PlacedSubmaps::read_block(BlockKey key, BlockValues& out) {
  out.fill(kUnknownRgbo);
  for (std::size_t i = placed_.size(); i-- > 0;) {
    const auto& keys = placed_[i]->keys;
    if (!std::binary_search(keys.begin(), keys.end(), key)) continue;
    placed_[i]->sampler.look_into(*placed_[i]->contents->get().voxels);
    if (placed_[i]->sampler.sample_unknown(key, out)) break;
  }
  return is_known(out);
}

std::unique_ptr<VoxelMap> PlacedSubmaps::whole() {
  const std::vector<BlockKey> all = keys();
  auto map = map_for_blocks(grid_, all.size());
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
  for (const auto& placed : placed_) bytes += (placed->keys.size() + placed->regions.size()) * sizeof(BlockKey);
  return bytes;
}

}  // namespace g3d::mapper::submaps
