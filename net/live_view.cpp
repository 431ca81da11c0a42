// SPDX-License-Identifier: Apache-2.0
#include "net/live_view.hpp"

#include "mapper/block_source.hpp"
#include "mapper/map_sampler.hpp"

namespace g3d::net {

LiveView::LiveView(const mapper::VoxelMap& own)
    : ring_(kBlocksAtOnce), others_(own.grid(), own.capacity()), view_(own, others_) {
  taken_.reserve(kBlocksAtOnce);
}

void LiveView::offer(std::span<const mapper::BlockKey> changed, const mapper::VoxelMap& others) {
  if (!changed.empty()) {
    due_.insert(due_.end(), changed.begin(), changed.end());
    mapper::sort_and_drop_repeats(due_);
  }
  std::size_t passed = 0;
  for (; passed < due_.size() && ring_.size() < ring_.capacity(); ++passed) {
    outgoing_.key = due_[passed];
    if (!others.read_stored_block(outgoing_.key, outgoing_.values)) outgoing_.values.fill(mapper::kUnknownRgbo);
    if (!ring_.try_push(outgoing_)) break;
  }
  due_.erase(due_.begin(), due_.begin() + static_cast<std::ptrdiff_t>(passed));
}

std::span<const std::uint32_t> LiveView::take_news() {
  taken_.clear();
  while (taken_.size() < kBlocksAtOnce && ring_.try_pop(incoming_)) {
    if (!mapper::is_known(incoming_.values)) {
      (void)others_.erase_block(incoming_.key);
    } else if (!others_.write_block(incoming_.key, incoming_.values)) {
      ++refused_blocks_;
      continue;
    }
    taken_.push_back(incoming_.key);
  }
  if (taken_.empty()) return {};
  return view_.on_others(taken_);
}

}  // namespace g3d::net
