// SPDX-License-Identifier: Apache-2.0
// One map out of two: a robot's own, which changes with every frame, and what the others have seen, merged and in the
// same grid. Block by block, so it costs as much as what changes. Memory is sized at construction. One thread.
#pragma once

#include <vector>

#include "mapper/pool.hpp"
#include "mapper/voxel_map.hpp"
#include "nav/shared_sight.hpp"

namespace g3d::net {

class SharedView final : public nav::SharedSight {
 public:
  /// `own` and `others` outlive this; both have `own`'s grid.
  SharedView(const mapper::VoxelMap& own, const mapper::VoxelMap& others);

  /// Slots whose block has gone, or is another one by now, are understood, too: as when a loop moves the map.
  std::span<const std::uint32_t> on_own(const mapper::VoxelMap& own, std::span<const std::uint32_t> slots) override;
  /// The same for blocks of the others' map, by their keys.
  std::span<const std::uint32_t> on_others(std::span<const mapper::BlockKey> keys);
  [[nodiscard]] const mapper::VoxelMap& map() const override { return view_; }
  /// Blocks for which there was no room.
  [[nodiscard]] std::uint64_t refused_blocks() const { return refused_blocks_; }

 private:
  /// What is to leave the view waits in gone_.
  void bring_up_to_date(mapper::BlockKey key);
  /// After all that has come: no slot is given away and taken again in one call, so that whoever follows the view by
  /// its slots misses nothing.
  void erase_gone();

  const mapper::VoxelMap& own_;
  const mapper::VoxelMap& others_;
  mapper::VoxelMap view_;
  mapper::ReservedArray<mapper::BlockKey> own_keys_;  ///< by own slot: key + 1 of the block that was in it, 0: none
  std::vector<mapper::BlockKey> gone_;
  std::vector<std::uint32_t> changed_;
  mapper::BlockValues own_values_{};
  mapper::BlockValues others_values_{};
  std::uint64_t refused_blocks_ = 0;
};

}  // namespace g3d::net
