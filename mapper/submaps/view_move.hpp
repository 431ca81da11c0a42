// SPDX-License-Identifier: Apache-2.0
// Brings the map that frames go into to where its submaps have been moved, a part at a time, while no frame goes in.
// First goes what is nowhere any more, then comes what is new or different: a slot is given away and taken again in
// different parts, so that whoever follows the map by its slots misses nothing. Thread: the map's writer. begin()
// allocates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "mapper/submaps/loop_search.hpp"
#include "mapper/submaps/submap_chain.hpp"

namespace g3d::mapper::submaps {

class ViewMove {
 public:
  explicit ViewMove(VoxelMap& view) : view_(view) {}

  /// The chain has been placed. `whole`: all of its submaps but the newest `fresh` ones.
  void begin(SubmapChain& chain, std::unique_ptr<VoxelMap> whole, std::size_t fresh);
  [[nodiscard]] bool is_done() const { return chain_ == nullptr; }
  /// Looks at so many blocks at most. Returns the slots that it has changed, each once, until the next call.
  std::span<const std::uint32_t> go_on(std::size_t most_blocks);
  /// Blocks for which there was no memory, of all moves.
  [[nodiscard]] std::uint64_t refused_blocks() const { return refused_blocks_; }

 private:
  void erase_next();
  void write_next();
  [[nodiscard]] bool read(BlockKey key, BlockValues& out);

  VoxelMap& view_;
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
