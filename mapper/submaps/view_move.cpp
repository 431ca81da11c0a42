// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/view_move.hpp"

#include <algorithm>
#include <cassert>
#include <iterator>
#include <utility>

namespace g3d::mapper::submaps {

void ViewMove::begin(SubmapChain& chain, std::unique_ptr<VoxelMap> whole, std::size_t fresh) {
  chain_ = &chain;
  whole_ = std::move(whole);
  fresh_keys_.clear();
  const PlacedSubmaps& placed = chain.placed();
  for (std::size_t i = placed.size() - fresh; i < placed.size(); ++i) {
    const auto keys = placed.keys_of(i);
    fresh_keys_.insert(fresh_keys_.end(), keys.begin(), keys.end());
  }
  sort_and_drop_repeats(fresh_keys_);
  there_ = whole_->sorted_keys();
  there_.insert(there_.end(), fresh_keys_.begin(), fresh_keys_.end());
  sort_and_drop_repeats(there_);
  const std::vector<BlockKey> now = view_.sorted_keys();
  gone_.clear();
  std::set_difference(now.begin(), now.end(), there_.begin(), there_.end(), std::back_inserter(gone_));
  next_gone_ = next_there_ = 0;
}

bool ViewMove::read(BlockKey key, BlockValues& out) {
  if (std::binary_search(fresh_keys_.begin(), fresh_keys_.end(), key)) return chain_->read_block(key, out);
  return whole_->read_stored_block(key, out);
}

void ViewMove::erase_next() {
  const BlockKey key = gone_[next_gone_++];
  const std::uint32_t slot = view_.find(key);
  if (slot != kNoSlot && view_.erase_block(key)) changed_slots_.push_back(slot);
}

void ViewMove::write_next() {
  const BlockKey key = there_[next_there_++];
  BlockValues wanted;
  BlockValues now;
  const bool knows = read(key, wanted);
  const bool is_there = view_.read_stored_block(key, now);
  if (!knows) wanted.fill(kUnknownRgbo);  // keeps its slot, if it has one: no other block must get it in this part
  if (is_there ? wanted == now : !knows) return;
  if (!view_.write_block(key, wanted)) {
    ++refused_blocks_;
    return;
  }
  changed_slots_.push_back(view_.find(key));
}

std::span<const std::uint32_t> ViewMove::go_on() {
  changed_slots_.clear();
  const bool erases = next_gone_ < gone_.size();
  for (std::size_t i = 0; i < most_blocks_; ++i) {
    if (erases ? next_gone_ == gone_.size() : next_there_ == there_.size()) break;
    erases ? erase_next() : write_next();
  }
  return changed_slots_;
}

void ViewMove::end() {
  assert(is_done());
  chain_ = nullptr;
  whole_.reset();
}

}  // namespace g3d::mapper::submaps
