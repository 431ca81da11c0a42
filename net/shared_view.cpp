// SPDX-License-Identifier: Apache-2.0
#include "net/shared_view.hpp"

#include "mapper/block_merge.hpp"
#include "mapper/block_source.hpp"

namespace g3d::net {

SharedView::SharedView(const mapper::VoxelMap& own, const mapper::VoxelMap& others)
    : own_(own), others_(others), view_(own.grid(), own.capacity()) {
  changed_.reserve(own.capacity().blocks);
}

void SharedView::bring_up_to_date(mapper::BlockKey key) {
  if (!own_.read_stored_block(key, own_values_)) own_values_.fill(mapper::kUnknownRgbo);
  if (others_.read_stored_block(key, others_values_)) mapper::merge_into(own_values_, others_values_);
  const std::uint32_t before = view_.find(key);
  if (!mapper::is_known(own_values_)) {
    if (before == mapper::kNoSlot) return;
    (void)view_.erase_block(key);
    changed_.push_back(before);
  } else if (view_.write_block(key, own_values_)) {
    changed_.push_back(view_.find(key));
  } else {
    ++refused_blocks_;
  }
}

std::span<const std::uint32_t> SharedView::on_own(const mapper::VoxelMap& own, std::span<const std::uint32_t> slots) {
  changed_.clear();
  for (const std::uint32_t slot : slots) bring_up_to_date(own.header(slot).key);
  return changed_;
}

std::span<const std::uint32_t> SharedView::on_others(std::span<const mapper::BlockKey> keys) {
  changed_.clear();
  for (const mapper::BlockKey key : keys) bring_up_to_date(key);
  return changed_;
}

}  // namespace g3d::net
