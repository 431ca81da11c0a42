// SPDX-License-Identifier: Apache-2.0
#include "mapper/windowed_blocks.hpp"

#include <algorithm>
#include <cassert>

#include "mapper/block_merge.hpp"

namespace g3d::mapper {

hal::Result<void> WindowedBlocks::visit_regions(const Visit& visit) const {
  unreadable_regions_ = 0;
  first_error_.clear();
  const std::vector<BlockKey> keys = map_.sorted_keys();
  const std::vector<RegionKey> stored = store_.sorted_regions();
  std::vector<StoredBlock> in_memory(kRegionBlocks);
  std::vector<StoredBlock> all(2 * kRegionBlocks);
  std::size_t next_key = 0;
  std::size_t next_stored = 0;
  while (next_key < keys.size() || next_stored < stored.size()) {
    RegionKey region = ~RegionKey{0};
    if (next_key < keys.size()) region = region_of(keys[next_key]);
    if (next_stored < stored.size()) region = std::min(region, stored[next_stored]);
    std::size_t count = 0;
    for (; next_key < keys.size() && region_of(keys[next_key]) == region; ++next_key, ++count) {
      in_memory[count].key = keys[next_key];
      map_.read_stored_block(keys[next_key], in_memory[count].values);
    }
    std::span<const StoredBlock> on_disk;
    if (next_stored < stored.size() && stored[next_stored] == region) {
      ++next_stored;
      const auto got = store_.get(region);
      if (got.ok()) on_disk = got.value();
      if (!got.ok() && ++unreadable_regions_ == 1) first_error_ = got.error().text;
    }
    const std::size_t merged = merge_lists(on_disk, std::span(in_memory).first(count), all);
    // Merging may leave a block without a single known voxel.
    const auto end = std::remove_if(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(merged),
                                    [](const StoredBlock& block) { return !is_known(block.values); });
    const auto known = static_cast<std::size_t>(end - all.begin());
    if (known == 0) continue;
    if (auto done = visit(std::span<const StoredBlock>(all).first(known)); !done) return done;
  }
  return {};
}

void add_blocks(VoxelMap& map, std::span<const StoredBlock> blocks) {
  BlockValues merged;
  for (const StoredBlock& block : blocks) {
    bool written = false;
    if (map.find(block.key) == kNoSlot) {
      written = map.write_block(block.key, block.values);
    } else {
      map.read_stored_block(block.key, merged);
      merge_into(merged, block.values);
      written = map.write_block(block.key, merged);
    }
    assert(written && "the caller looked for room");
    (void)written;
  }
}

bool gather(VoxelMap& map, PageStore& store) {
  const auto size = measure(WindowedBlocks(map, store));
  if (!size.ok() || !fits(size.value().needed, map.capacity())) return false;
  for (const RegionKey region : store.sorted_regions()) {
    const auto blocks = store.get(region);
    if (!blocks.ok()) continue;
    if (!fits(store.find(region)->needed(), map.available())) return false;
    add_blocks(map, blocks.value());
    store.drop(region);
  }
  return true;
}

}  // namespace g3d::mapper
