// SPDX-License-Identifier: Apache-2.0
// A chain of submaps becomes our own layer: each submap's blocks once, under a number of its own, and where it stands.
// When a loop is closed only poses are published, a few bytes each; voxels do not travel again. A submap that was
// joined to the one before it is published anew, as part of that, and its own blocks become unknown.
//
// The newest submap that knows a voxel says what it is, so numbers ascend from old to new. Thread: the one that
// gossips, while nobody works on the chain. Allocates when a submap is new.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/messages.hpp"
#include "mapper/submaps/submap_chain.hpp"
#include "net/block_wire.hpp"
#include "net/gossip.hpp"
#include "net/layer_writer.hpp"
#include "net/placement.hpp"

namespace g3d::net {

struct ChainCounts {
  std::uint64_t published_submaps = 0;  ///< times one was begun, joined ones anew
  std::uint64_t published_blocks = 0;
  std::uint64_t published_bytes = 0;
  std::uint64_t published_poses = 0;
  std::uint64_t retracted_submaps = 0;
  std::uint64_t refused_records = 0;  ///< no room in the store; tried again in the next round
  std::uint64_t refused_submaps = 0;  ///< more than a layer may have, less one for what is newer than the chain
  [[nodiscard]] bool operator==(const ChainCounts&) const = default;
};

class ChainWriter {
 public:
  /// `gossip` and `store` outlive this. `grid`: of all submaps.
  ChainWriter(Gossip& gossip, const LayerStore& store, const mapper::Grid& grid, const GroundBand& band = {})
      : gossip_(gossip), store_(store), grid_(grid), band_(band) {}

  /// One round: poses that have changed, then blocks, the oldest submap's first, until more than so many bytes are
  /// published. Returns how many bytes.
  std::size_t publish_round(const mapper::submaps::SubmapChain& chain, const Placement& placement,
                            std::size_t most_bytes, hal::TimeNs now_ns);
  [[nodiscard]] const ChainCounts& counts() const { return counts_; }
  /// Everything is published.
  [[nodiscard]] bool is_up_to_date() const;

 private:
  struct Due {
    mapper::BlockKey key;
    Lane lane;
  };
  /// A submap as it was published, known by when it begins; when it ends tells whether it is the same still.
  struct Told {
    hal::TimeNs first_ns = 0;
    hal::TimeNs last_ns = 0;
    std::uint32_t number = 0;
    bool is_gone = false;
    std::vector<Due> due;  ///< in the order in which they go
    std::size_t next_due = 0;
    std::vector<mapper::BlockKey> keys;  ///< of what was published, ascending
  };
  void look_at(const mapper::submaps::SubmapChain& chain);
  void begin(Told& told, const mapper::submaps::Submap& submap);
  void retract(Told& told);
  bool publish_pose(const Told& told, const mapper::submaps::Submap& submap, const Placement& placement,
                    std::size_t& bytes);
  /// False if the store has no room.
  bool publish_block(std::uint32_t number, const Due& due, std::size_t& bytes);
  [[nodiscard]] bool is_published(RecordKey key, mapper::ByteSpan payload) const;

  Gossip& gossip_;
  const LayerStore& store_;
  mapper::Grid grid_;
  GroundBand band_;
  std::vector<Told> told_;  ///< by number, ascending
  std::uint32_t next_number_ = 0;
  BlockPacker packer_;
  mapper::BlockValues values_{};
  ChainCounts counts_;
};

}  // namespace g3d::net
