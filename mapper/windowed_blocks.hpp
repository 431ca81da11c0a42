// SPDX-License-Identifier: Apache-2.0
// The whole of a map that lies partly in memory and partly on disk, as one source of blocks.
#pragma once

#include <string>

#include "mapper/block_source.hpp"
#include "mapper/page_store.hpp"

namespace g3d::mapper {

/// References outlive this; nobody writes to either while it is read. A region that is in both (it was touched before
/// it had come back) is merged. One that cannot be read any more is left out and counted: the others are still there.
class WindowedBlocks final : public BlockSource {
 public:
  WindowedBlocks(const VoxelMap& map, const PageStore& store) : map_(map), store_(store) {}
  [[nodiscard]] const Grid& grid() const override { return map_.grid(); }
  hal::Result<void> visit_regions(const Visit& visit) const override;

  // Of the last visit
  [[nodiscard]] std::uint64_t unreadable_regions() const { return unreadable_regions_; }
  [[nodiscard]] const std::string& first_error() const { return first_error_; }

 private:
  const VoxelMap& map_;
  const PageStore& store_;
  mutable std::uint64_t unreadable_regions_ = 0;
  mutable std::string first_error_;
};

/// Brings everything back into memory, if the map's pools can hold it: true. Else what fits has moved, and the whole is
/// still what it was. Records that cannot be read stay in the store.
[[nodiscard]] bool gather(VoxelMap& map, PageStore& store);

/// Writes blocks of a region that is elsewhere into the map; what is known there already is merged. The map needs room
/// for all of them.
void add_blocks(VoxelMap& map, std::span<const StoredBlock> blocks);

}  // namespace g3d::mapper
