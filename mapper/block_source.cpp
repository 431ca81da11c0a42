// SPDX-License-Identifier: Apache-2.0
#include "mapper/block_source.hpp"

#include <algorithm>

namespace g3d::mapper {

bool is_known(const BlockValues& values) {
  return std::any_of(values.begin(), values.end(), [](Rgbo v) { return level_of(v) != kUnknownLevel; });
}

hal::Result<void> MemoryBlocks::visit_regions(const Visit& visit) const {
  const std::vector<BlockKey> keys = map_.sorted_keys();
  std::vector<StoredBlock> blocks(std::min<std::size_t>(keys.size(), kRegionBlocks));
  for (std::size_t begin = 0; begin < keys.size();) {
    std::size_t count = 0;
    while (begin + count < keys.size() && region_of(keys[begin + count]) == region_of(keys[begin])) {
      blocks[count].key = keys[begin + count];
      map_.read_stored_block(blocks[count].key, blocks[count].values);
      ++count;
    }
    if (auto done = visit(std::span(blocks).first(count)); !done) return done;
    begin += count;
  }
  return {};
}

void SourceSize::add(const BlockValues& values) {
  ++needed.blocks;
  ++counts.blocks;
  bool uniform = true;
  for (int brick = 0; brick < kBricksPerBlock; ++brick) {
    bool has_colour = false;
    for (int i = brick * kBrickVoxels; i < (brick + 1) * kBrickVoxels; ++i) {
      const Rgbo value = values[static_cast<std::size_t>(i)];
      uniform &= value == values[0];
      const State state = state_of(value);
      counts.occupied += state == State::occupied ? 1 : 0;
      counts.free += state == State::free ? 1 : 0;
      const bool coloured = (value & kHasColourBit) != 0;
      counts.coloured += coloured ? 1 : 0;
      has_colour |= coloured;
    }
    needed.colour_bricks += has_colour ? 1 : 0;
  }
  uniform &= (values[0] & kHasColourBit) == 0;
  needed.planes += uniform ? 0 : 1;
  counts.uniform_blocks += uniform ? 1 : 0;
}

hal::Result<SourceSize> measure(const BlockSource& source) {
  SourceSize size;
  const auto done = source.visit_regions([&](std::span<const StoredBlock> blocks) {
    for (const StoredBlock& block : blocks) size.add(block.values);
    return hal::Result<void>{};
  });
  if (!done) return done.error();
  return size;
}

}  // namespace g3d::mapper
