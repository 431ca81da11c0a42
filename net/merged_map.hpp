// SPDX-License-Identifier: Apache-2.0
// The one map of all layers: every submap of every layer, placed in the world as its writer says, resampled into one
// grid. In a layer the newest submap that knows a voxel says what it is, as in its writer's own map; layers are summed
// voxel by voxel (mapper/voxel_tally.hpp). A function of the records alone: whoever holds the same
// records has the same map, in whatever order they came. Kept up to date block by block; what an update costs depends
// on what has changed.
//
// A layer that the store refuses leaves the map with all that it had put there. A submap whose pose is not known yet
// waits. Each has address space for as much as one map may hold from the start: pages that are not touched cost
// nothing, and an update allocates nothing. One thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "hal/geometry.hpp"
#include "mapper/map_sampler.hpp"
#include "mapper/voxel_map.hpp"
#include "mapper/voxel_tally.hpp"
#include "net/block_wire.hpp"
#include "net/layer_store.hpp"

namespace g3d::net {

struct MergedOptions {
  mapper::Grid grid;
  mapper::MapCapacity merged;
  mapper::MapCapacity submap;
  std::size_t most_submaps = 64;  ///< of all layers together
  std::optional<LayerId> left_out =
      std::nullopt;                 ///< a layer that does not count: a robot's own, which it knows better
  std::uint32_t left_out_from = 0;  ///< of that layer, this submap and those after it; earlier starts wrote the others
  hal::Pose T_world_merged{};       ///< where the result's grid lies in the world
};

struct MergedCounts {
  std::uint64_t merged_blocks = 0;    ///< times a block of the result was made
  std::uint64_t moved_submaps = 0;    ///< times a pose has changed
  std::uint64_t dropped_submaps = 0;  ///< of robots that were refused
  std::uint64_t bad_payloads = 0;     ///< records that are no block or no pose: left out
  std::uint64_t other_grids = 0;      ///< poses of submaps whose voxels have another size: they wait for ever
  std::uint64_t refused_blocks = 0;   ///< no room
  std::uint64_t refused_submaps = 0;  ///< too many
};

class MergedMap {
 public:
  explicit MergedMap(const MergedOptions& options);

  /// Where the result's grid stands from now on; all of it is made anew by the next update. At the world's origin at
  /// first.
  void place(const hal::Pose& T_world_merged);
  /// Takes what has changed in the store since the last time.
  void update(LayerStore& store);
  /// The same from all that is in the store, for a map that begins now.
  void take_all(const LayerStore& store);
  [[nodiscard]] const mapper::VoxelMap& map() const { return merged_; }
  /// Blocks of the result that the last update has made anew.
  [[nodiscard]] std::span<const mapper::BlockKey> changed_keys() const { return due_; }
  [[nodiscard]] const MergedCounts& counts() const { return counts_; }
  [[nodiscard]] std::size_t submap_count() const { return submaps_.size(); }

 private:
  struct Submap {
    LayerId layer;
    LayerIndex index = kNoLayer;
    std::uint32_t number = 0;
    std::uint64_t rank =
        0;  ///< place in the order of layers and numbers: who gives the colour of two equally sure ones
    std::unique_ptr<mapper::VoxelMap> map;
    hal::Pose T_world_submap;
    std::optional<mapper::MapSampler> sampler;  ///< none: its pose is not known
  };
  /// nullptr if there are too many.
  [[nodiscard]] Submap* submap_of(const LayerStore& store, LayerIndex layer, std::uint32_t number);
  void take(const LayerStore& store, LayerIndex layer, RecordKey key);
  void take_block(const LayerStore& store, LayerIndex layer, RecordKey key);
  void take_pose(const LayerStore& store, LayerIndex layer, std::uint32_t number);
  void drop(LayerIndex layer);
  void rank_submaps();
  [[nodiscard]] mapper::ByteSpan payload_of(const LayerStore& store, const StoredRecord& record);
  /// What a layer says of a block; its submaps are [first, end) of order_. False: nothing.
  bool sample_layer(std::size_t first, std::size_t end, mapper::BlockKey key);
  void begin_update();
  /// `source_keys`: of a submap that has a place.
  void add_due(const Submap& submap, std::span<const mapper::BlockKey> source_keys);
  /// In keys_, until the next call.
  [[nodiscard]] std::span<const mapper::BlockKey> keys_of(const mapper::VoxelMap& map);
  void merge_due();

  /// Where the submap stands to the result, from what is known by now.
  void look_from_there(Submap& submap);

  MergedOptions options_;
  hal::Pose T_world_merged_;
  bool is_placed_anew_ = false;
  mapper::VoxelMap merged_;
  std::vector<Submap> submaps_;                           ///< reserved
  std::vector<std::unique_ptr<mapper::VoxelMap>> spare_;  ///< for those that come
  std::vector<std::size_t> order_;      ///< those that are placed: layer by layer, the newest first; reserved
  std::vector<mapper::BlockKey> due_;   ///< blocks of the result; reserved
  std::vector<mapper::BlockKey> keys_;  ///< of a submap; reserved
  BlockUnpacker unpacker_;
  std::vector<std::uint8_t> payload_;
  mapper::BlockValues values_{};
  mapper::BlockValues older_{};
  mapper::BlockTally tally_{};
  MergedCounts counts_;
};

}  // namespace g3d::net
