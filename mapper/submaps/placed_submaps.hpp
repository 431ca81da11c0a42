// SPDX-License-Identifier: Apache-2.0
// Submaps where they stand, as one map: the newest that knows a voxel says what it is. Thread: one. Allocates when a
// submap is added.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "hal/geometry.hpp"
#include "mapper/map_sampler.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper::submaps {

class PlacedSubmaps {
 public:
  /// `grid`: of the map that they make together, in the world frame.
  explicit PlacedSubmaps(const Grid& grid) : grid_(grid) {}

  /// The next newer one. `voxels` outlives this.
  void add(const VoxelMap& voxels, const hal::Pose& T_world_stored);
  /// One of them and the next have become one.
  void join(std::size_t submap, const VoxelMap& voxels, const hal::Pose& T_world_stored);
  [[nodiscard]] std::size_t size() const { return placed_.size(); }
  /// Blocks of the common map that one of them may touch, ascending.
  [[nodiscard]] std::span<const BlockKey> keys_of(std::size_t submap) const { return placed_[submap]->keys; }
  /// The same for all of them together, each once.
  [[nodiscard]] std::vector<BlockKey> keys() const;
  /// One block, stored codes. False if no submap knows any voxel of it.
  bool read_block(BlockKey key, BlockValues& out);
  /// All of them as a map of its own.
  [[nodiscard]] std::unique_ptr<VoxelMap> whole();
  [[nodiscard]] std::uint64_t memory_bytes() const;

 private:
  struct Placed {
    MapSampler sampler;
    std::vector<BlockKey> keys;
  };
  [[nodiscard]] std::unique_ptr<Placed> place(const VoxelMap& voxels, const hal::Pose& T_world_stored) const;

  Grid grid_;
  std::vector<std::unique_ptr<Placed>> placed_;
};

}  // namespace g3d::mapper::submaps
