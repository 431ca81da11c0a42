// SPDX-License-Identifier: Apache-2.0
// All known blocks of a map in ascending order of key, wherever they lie: in memory, or paged out. Hashing, counting
// and saving go through this, a region at a time, so that a map may be larger than memory.
#pragma once

#include <functional>
#include <span>

#include "hal/result.hpp"
#include "mapper/files/block_codec.hpp"
#include "mapper/region.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

class BlockSource {
 public:
  /// The blocks of one region, at least one, each with a known voxel. What it returns as failure ends the visit.
  using Visit = std::function<hal::Result<void>(std::span<const StoredBlock>)>;

  virtual ~BlockSource() = default;
  [[nodiscard]] virtual const Grid& grid() const = 0;
  /// The same blocks every time, as long as nobody writes.
  virtual hal::Result<void> visit_regions(const Visit& visit) const = 0;
};

/// A map that lies in memory as a whole. The map outlives this.
class MemoryBlocks final : public BlockSource {
 public:
  explicit MemoryBlocks(const VoxelMap& map) : map_(map) {}
  [[nodiscard]] const Grid& grid() const override { return map_.grid(); }
  hal::Result<void> visit_regions(const Visit& visit) const override;

 private:
  const VoxelMap& map_;
};

[[nodiscard]] bool is_known(const BlockValues& values);

/// What its blocks need in memory, and what VoxelMap::counts() would say of them.
struct SourceSize {
  MapCapacity needed{0, 0, 0};
  MapCounts counts;
  void add(const BlockValues& values);
};
[[nodiscard]] hal::Result<SourceSize> measure(const BlockSource& source);

}  // namespace g3d::mapper
