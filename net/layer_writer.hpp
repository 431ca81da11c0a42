// SPDX-License-Identifier: Apache-2.0
// Our own map becomes our own layer: blocks that have changed since the last round are published, coded as they travel,
// what matters first. A block that changed and is as it was published already costs nothing; one that is gone is
// published as unknown.
// Threads: note_changed() belongs to the one that writes the map, all else to the one that gossips; blocks are copied
// under their sequence locks. Allocates at construction.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hal/geometry.hpp"
#include "hal/messages.hpp"
#include "mapper/dirty_slots.hpp"
#include "mapper/voxel_map.hpp"
#include "net/block_wire.hpp"
#include "net/gossip.hpp"
#include "net/placement.hpp"

namespace g3d::net {

/// Where robots drive, in the map's own frame: blocks that reach into this band go first.
struct GroundBand {
  float low_m = -0.1F;
  float high_m = 0.7F;
};

/// Ground band, else an edge of what is known, else the rest.
[[nodiscard]] Lane lane_of(mapper::BlockKey key, const mapper::BlockValues& values, const mapper::Grid& grid,
                           const GroundBand& band);

struct WriterCounts {
  std::uint64_t published_blocks = 0;
  std::uint64_t published_bytes = 0;
  std::uint64_t unchanged_blocks = 0;  ///< had been published like that
  std::uint64_t refused_blocks = 0;    ///< no room in the store; tried again in the next round
  std::uint64_t put_off_blocks = 0;    ///< for later rounds, as there was no more to be sent in one
};

class LayerWriter {
 public:
  /// `map`, `gossip` and `store` outlive this.
  LayerWriter(const mapper::VoxelMap& map, Gossip& gossip, const LayerStore& store, const GroundBand& band = {},
              std::uint32_t submap = 0);

  void note_changed(std::span<const std::uint32_t> slots) { dirty_.note(slots); }
  /// Blocks that were published and that `stays(slot)` is not true of become unknown in this submap, as others hold
  /// them: with the next rounds, unless they change before.
  template <typename Stays>
  void withdraw_unless(Stays&& stays) {
    for (std::uint32_t slot = 0; slot < map_.slot_end(); ++slot) {
      if (told_[slot] != 0 && !stays(slot)) withdrawn_.note(slot);
    }
  }
  /// Where the layer stands in the world. False if the store has no room.
  bool publish_pose(const hal::Pose& T_world_map, hal::TimeNs now_ns) {
    return publish_placement(Placement::as_said(T_world_map, gossip_.options().self), now_ns);
  }
  /// The same with how that is known.
  bool publish_placement(const Placement& placement, hal::TimeNs now_ns);
  /// One round: what has changed, until more than so many bytes are published. Returns how many bytes.
  std::size_t publish_round(std::size_t most_bytes, hal::TimeNs now_ns);
  [[nodiscard]] const WriterCounts& counts() const { return counts_; }

 private:
  struct Due {
    Lane lane;
    mapper::BlockKey key;
    std::uint32_t slot;
    bool is_gone;  ///< nothing of that key is in the slot any more
    bool is_withdrawn = false;
    [[nodiscard]] bool operator<(const Due& other) const {
      if (is_gone != other.is_gone) return is_gone;
      if (lane != other.lane) return lane < other.lane;
      return key < other.key;
    }
  };
  void collect();
  void note_again(const Due& due) { (due.is_withdrawn ? withdrawn_ : dirty_).note(due.slot); }
  [[nodiscard]] bool is_published(RecordKey key, mapper::ByteSpan payload) const;
  /// False if the store has no room. Adds to `bytes`.
  bool publish(const Due& due, std::size_t& bytes);

  const mapper::VoxelMap& map_;
  Gossip& gossip_;
  const LayerStore& store_;
  GroundBand band_;
  std::uint32_t submap_;
  mapper::DirtySlots dirty_;
  mapper::DirtySlots withdrawn_;
  mapper::ReservedArray<mapper::BlockKey> told_;  ///< by slot: key + 1 of what was published of it; 0: nothing
  std::vector<Due> due_;
  BlockPacker packer_;
  mapper::BlockValues values_{};
  WriterCounts counts_;
};

}  // namespace g3d::net
