// SPDX-License-Identifier: Apache-2.0
// Submaps where they stand, as one map: the newest that knows a voxel says what it is. Thread: one. Allocates when a
// submap is added, and when one is asked that lies on the shelf.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "hal/geometry.hpp"
#include "mapper/map_sampler.hpp"
#include "mapper/region.hpp"
#include "mapper/submaps/shelved_contents.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper::submaps {

class PlacedSubmaps {
 public:
  /// `grid`: of the map that they make together, in the world frame.
  explicit PlacedSubmaps(const Grid& grid) : grid_(grid) {}

  /// The next newer one. `contents` outlives this.
  void add(ShelvedContents& contents, const hal::Pose& T_world_stored);
  /// One of them and the next have become one.
  void join(std::size_t submap, ShelvedContents& contents, const hal::Pose& T_world_stored);
  [[nodiscard]] std::size_t size() const { return placed_.size(); }
  /// Blocks of the common map that one of them may touch, ascending.
  [[nodiscard]] std::span<const BlockKey> keys_of(std::size_t submap) const { return placed_[submap]->keys; }
  /// The same for all of them together, each once.
  [[nodiscard]] std::vector<BlockKey> keys() const;
  /// Those of one region.
  [[nodiscard]] std::vector<BlockKey> keys_in(RegionKey region) const;
  /// Regions in which any submap may know something, ascending.
  [[nodiscard]] std::vector<RegionKey> regions() const;
  /// Square of the distance in voxels from `v` to the nearest region that one of them may touch.
  [[nodiscard]] std::int64_t squared_distance_cells(std::size_t submap, const VoxelIndex& v) const;
  /// One block, stored codes. False if no submap knows any voxel of it.
  bool read_block(BlockKey key, BlockValues& out);
  /// All of them as a map of its own.
  [[nodiscard]] std::unique_ptr<VoxelMap> whole();
  [[nodiscard]] std::uint64_t memory_bytes() const;

 private:
  struct Placed {
    MapSampler sampler;
    ShelvedContents* contents;
    std::vector<BlockKey> keys;
    std::vector<RegionKey> regions;
  };
  [[nodiscard]] std::unique_ptr<Placed> place(ShelvedContents& contents, const hal::Pose& T_world_stored) const;

  Grid grid_;
  std::vector<std::unique_ptr<Placed>> placed_;
};

}  // namespace g3d::mapper::submaps
