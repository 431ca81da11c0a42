// SPDX-License-Identifier: Apache-2.0
// Brings the map that frames go into to where its submaps have been moved, a part at a time, while no frame goes in.
// First goes what is nowhere any more, then comes what is new or different: a slot is given away and taken again in
// different parts, so that whoever follows the map by its slots misses nothing. Thread: the map's writer; begin() and
// end(), which allocate and give back, may be another's while nobody writes to the map.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "mapper/submaps/placed_submaps.hpp"
#include "mapper/submaps/submap_chain.hpp"

namespace g3d::mapper::submaps {

class ViewMove {
 public:
  /// `most_blocks`: of a part.
  ViewMove(VoxelMap& view, std::size_t most_blocks) : view_(view), most_blocks_(most_blocks) {
    changed_slots_.reserve(most_blocks);
  }

  /// The chain has been placed. `whole`: all of its submaps but the newest `fresh` ones.
  void begin(SubmapChain& chain, std::unique_ptr<VoxelMap> whole, std::size_t fresh);
  [[nodiscard]] bool is_done() const { return next_gone_ == gone_.size() && next_there_ == there_.size(); }
  /// The next part. Returns the slots that it has changed, each once, until the next call.
  std::span<const std::uint32_t> go_on();
  /// Gives memory back. Once it is done.
  void end();
  /// Blocks for which there was no memory, of all moves.
  [[nodiscard]] std::uint64_t refused_blocks() const { return refused_blocks_; }

 private:
  void erase_next();
  void write_next();
  [[nodiscard]] bool read(BlockKey key, BlockValues& out);

  VoxelMap& view_;
  std::size_t most_blocks_;
  SubmapChain* chain_ = nullptr;
  std::unique_ptr<VoxelMap> whole_;
  std::vector<BlockKey> fresh_keys_;  ///< ascending
  std::vector<BlockKey> gone_;
  std::vector<BlockKey> there_;
  std::size_t next_gone_ = 0;
  std::size_t next_there_ = 0;
  std::vector<std::uint32_t> changed_slots_;
  std::uint64_t refused_blocks_ = 0;
};

}  // namespace g3d::mapper::submaps
