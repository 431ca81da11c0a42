// SPDX-License-Identifier: Apache-2.0
// What a robot in threads drives by while others share their maps with it. The sharing thread merges what the others
// have seen and hands changed blocks over by value, through a ring; the navigator's thread keeps a copy of them and
// joins it with the robot's own map:
//
//   sharing thread: merged map of the others ─changed blocks─▶ due ─▶ ring ─▶ copy ─┐
//   navigator's thread, while the own map is its:               own map ────────────┴▶ SharedView
//
// Nothing is lost when the ring is full: what is due waits with the sharing thread, changes of one block coalesce
// there, and the block is read when there is room. Memory is sized at construction, but for what is due.
#pragma once

#include <span>
#include <vector>

#include "hal/ring.hpp"
#include "mapper/voxel_map.hpp"
#include "nav/shared_sight.hpp"
#include "net/shared_view.hpp"

namespace g3d::net {

class LiveView final : public nav::SharedSight {
 public:
  /// So many are taken along with a frame, in some milliseconds: 5000 blocks a second at 10 Hz.
  static constexpr std::size_t kBlocksAtOnce = 512;

  /// `own` outlives this.
  explicit LiveView(const mapper::VoxelMap& own);

  // The sharing thread's
  /// Blocks of the others' map that have changed; passes on as many as there is room for, those from before too.
  void offer(std::span<const mapper::BlockKey> changed, const mapper::VoxelMap& others);
  /// Changed blocks that are not passed on yet.
  [[nodiscard]] std::size_t due() const { return due_.size(); }

  // The navigator's thread
  std::span<const std::uint32_t> on_own(const mapper::VoxelMap& own, std::span<const std::uint32_t> slots) override {
    return view_.on_own(own, slots);
  }
  std::span<const std::uint32_t> take_news() override;
  [[nodiscard]] const mapper::VoxelMap& map() const override { return view_.map(); }
  /// For lack of room in the copy.
  [[nodiscard]] std::uint64_t refused_blocks() const { return refused_blocks_ + view_.refused_blocks(); }

 private:
  struct News {
    mapper::BlockKey key;
    mapper::BlockValues values;  ///< all unknown: there is no such block any more
  };

  std::vector<mapper::BlockKey> due_;  ///< the sharing thread's; ascending
  News outgoing_{};                    ///< the same
  hal::Ring<News> ring_;

  mapper::VoxelMap others_;
  SharedView view_;
  News incoming_{};
  std::vector<mapper::BlockKey> taken_;
  std::uint64_t refused_blocks_ = 0;
};

}  // namespace g3d::net
