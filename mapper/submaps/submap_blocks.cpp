// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/submap_blocks.hpp"

#include <span>
#include <vector>

namespace g3d::mapper::submaps {

hal::Result<void> SubmapBlocks::visit_regions(const Visit& visit) const {
  const VoxelMap& view = chain_.view();
  std::vector<RegionKey> regions = chain_.placed().regions();
  for (const BlockKey key : view.sorted_keys()) regions.push_back(region_of(key));
  sort_and_drop_repeats(regions);
  std::vector<StoredBlock> blocks(kRegionBlocks);
  for (const RegionKey region : regions) {
    std::size_t count = 0;
    const auto take = [&](BlockKey key, bool is_there) {
      if (!is_there || !is_known(blocks[count].values)) return;
      blocks[count++].key = key;
    };
    if (window_.is_out(region)) {
      for (const BlockKey key : chain_.placed().keys_in(region)) {
        take(key, chain_.read_block(key, blocks[count].values));
      }
    } else {
      for (BlockKey key = first_block(region); key < first_block(region + 1); ++key) {
        if (view.find(key) != kNoSlot) take(key, view.read_stored_block(key, blocks[count].values));
      }
    }
    chain_.put_away_all_but(kKept);
    if (count == 0) continue;
    if (auto done = visit(std::span<const StoredBlock>(blocks).first(count)); !done) return done;
  }
  return {};
}

}  // namespace g3d::mapper::submaps
