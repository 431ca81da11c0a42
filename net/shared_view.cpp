// SPDX-License-Identifier: Apache-2.0
#include "net/shared_view.hpp"

#include "mapper/block_merge.hpp"
#include "mapper/block_source.hpp"

namespace g3d::net {

SharedView::SharedView(const mapper::VoxelMap& own, const mapper::VoxelMap& others)
    : own_(own), others_(others), view_(own.grid(), own.capacity()), own_keys_(own.capacity().blocks) {
  changed_.reserve(own.capacity().blocks);
  gone_.reserve(own.capacity().blocks);
}

void SharedView::bring_up_to_date(mapper::BlockKey key) {
  if (!own_.read_stored_block(key, own_values_)) own_values_.fill(mapper::kUnknownRgbo);
  if (others_.read_stored_block(key, others_values_)) mapper::merge_into(own_values_, others_values_);
  if (!mapper::is_known(own_values_)) {
    if (view_.find(key) != mapper::kNoSlot) gone_.push_back(key);
  } else if (view_.write_block(key, own_values_)) {
    changed_.push_back(view_.find(key));
  } else {
    ++refused_blocks_;
  }
}

void SharedView::erase_gone() {
  for (const mapper::BlockKey key : gone_) {
    const std::uint32_t slot = view_.find(key);
    if (slot == mapper::kNoSlot) continue;  // was named twice
    (void)view_.erase_block(key);
    changed_.push_back(slot);
  }
  gone_.clear();
}

std::span<const std::uint32_t> SharedView::on_own(const mapper::VoxelMap& own, std::span<const std::uint32_t> slots) {
  changed_.clear();
  for (const std::uint32_t slot : slots) {
    const mapper::BlockKey key = own.header(slot).key;
    const mapper::BlockKey before = own_keys_[slot];
    if (before != 0 && before != key + 1) bring_up_to_date(before - 1);
    own_keys_[slot] = key == mapper::VoxelMap::kNoKey ? 0 : key + 1;
    if (key != mapper::VoxelMap::kNoKey) bring_up_to_date(key);
  }
  erase_gone();
  return changed_;
}

std::span<const std::uint32_t> SharedView::on_others(std::span<const mapper::BlockKey> keys) {
  changed_.clear();
  for (const mapper::BlockKey key : keys) bring_up_to_date(key);
  erase_gone();
  return changed_;
}

}  // namespace g3d::net
