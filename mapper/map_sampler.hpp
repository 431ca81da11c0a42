// SPDX-License-Identifier: Apache-2.0
// One map as seen from another's grid. A map of the same resolution, not turned against it and shifted by whole voxels,
// is taken exactly. Others are resampled: each target voxel looks up the source voxel that its centre falls into, and
// where maps are merged, walls that pass between the centres are closed (wall_closing.hpp).
// Thread: while nobody writes the map.
#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "hal/geometry.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

enum class Walls : std::uint8_t {
  as_centres_say,
  closed,  ///< what the map keeps apart, the grid keeps apart; not in a grid coarser than the map
};

class MapSampler {
 public:
  /// `map` outlives the sampler.
  MapSampler(const VoxelMap& map, const hal::Pose& T_world_map, const Grid& target, const hal::Pose& T_world_target,
             Walls walls = Walls::as_centres_say)
      : MapSampler(map.grid(), T_world_map, target, T_world_target, walls) {
    look_into(map);
  }
  /// Of a map that is elsewhere for now: look_into() before anything is sampled.
  MapSampler(const Grid& source, const hal::Pose& T_world_map, const Grid& target, const hal::Pose& T_world_target,
             Walls walls = Walls::as_centres_say);
  /// `map`: with the blocks that it had the last time, wherever it lies by now.
  void look_into(const VoxelMap& map) {
    source_ = &map;
    cached_key_ = VoxelMap::kNoKey;
  }

  /// Appends every target block that a block of the map may touch; some of them twice.
  void add_target_keys(std::vector<BlockKey>& keys) const { add_target_keys(source_->sorted_keys(), keys); }
  /// The same for blocks of the map that somebody has listed.
  void add_target_keys(std::span<const BlockKey> source_keys, std::vector<BlockKey>& keys) const;
  /// The map's codes (stored form) at the 512 voxels of a target block.
  /// False: none is known, for there is no block of the map anywhere near.
  bool sample(BlockKey target_key, BlockValues& out);
  /// The same for those that are unknown in `values`, as the centres say. True if none is left.
  bool sample_unknown(BlockKey target_key, BlockValues& values);

 private:
  [[nodiscard]] bool takes_whole_blocks() const {
    return is_aligned_ && shift_.x % 8 == 0 && shift_.y % 8 == 0 && shift_.z % 8 == 0;
  }
  /// Whether the map has a block that a centre of the target block, or one beside it, may fall into.
  [[nodiscard]] bool has_block_near(const VoxelIndex& target_origin) const;
  /// A pose as matrix in double precision: at 1 km a float's last bit is a tenth of a millimetre already.
  struct Transform {
    std::array<double, 9> rotation;
    std::array<double, 3> translation_m;
    [[nodiscard]] std::array<double, 3> apply(const std::array<double, 3>& p) const;
  };
  struct Box {
    VoxelIndex low, high;
  };
  [[nodiscard]] static Transform transform_of(const hal::Pose& pose);
  /// Whether source voxel = target voxel + shift_ holds everywhere.
  [[nodiscard]] bool find_shift();
  /// Target voxels whose centres may fall into a source block.
  [[nodiscard]] Box touched_box(const VoxelIndex& origin) const;
  [[nodiscard]] double edge_m(std::int32_t k) const;
  /// Of a target voxel's centre, in source voxels: it lies in voxel 32767 + ceil().
  [[nodiscard]] std::array<double, 3> centre_cells(const VoxelIndex& target) const;
  [[nodiscard]] VoxelIndex source_voxel(const VoxelIndex& target) const;
  [[nodiscard]] Rgbo look_up(const VoxelIndex& v);

  const VoxelMap* source_ = nullptr;
  Grid source_grid_;
  Grid target_;
  Transform T_source_target_{};
  Transform cells_of_target_{};  ///< from metres in the target's frame to voxels of the source
  Transform T_target_source_{};
  bool is_aligned_ = false;
  bool closes_walls_ = false;
  VoxelIndex shift_;
  BlockKey cached_key_ = VoxelMap::kNoKey;
  std::uint32_t cached_slot_ = kNoSlot;
};

/// For keys that several samplers have added.
void sort_and_drop_repeats(std::vector<BlockKey>& keys);

}  // namespace g3d::mapper
