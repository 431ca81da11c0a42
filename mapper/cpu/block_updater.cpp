// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/block_updater.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace g3d::mapper::cpu {
namespace {

// The box in whole groups of 4x4x4 blocks, the unit in which visible blocks are dealt out.
std::size_t rounded_box_blocks(const SensorGeometry& sensor) {
  const auto side = static_cast<std::size_t>((sensor.max_side_blocks + 3) / 4 * 4);
  return side * side * side;
}

// Low key bits that name a cube of blocks about as large as a frame's box usually is.
std::uint64_t slot_cache_mask(const SensorGeometry& sensor) {
  const auto side = static_cast<std::uint64_t>(std::bit_ceil(static_cast<unsigned>(3 * sensor.max_side_blocks / 4)));
  return side * side * side - 1;
}

}  // namespace

BlockUpdater::BlockUpdater(VoxelMap& map, const SensorGeometry& sensor, UpdateSteps steps)
    : map_(&map),
      steps_(steps),
      most_chunks_(rounded_box_blocks(sensor) / 64 + HitScatter::kShards),
      slot_cache_mask_(slot_cache_mask(sensor)),
      slot_cache_(slot_cache_mask_ + 1),
      waiting_(rounded_box_blocks(sensor) * 2),
      lane_changed_(rounded_box_blocks(sensor) * 2),
      lane_shrinking_(rounded_box_blocks(sensor) * 2),
      stored_flags_(rounded_box_blocks(sensor)),
      lanes_(most_chunks_),
      changed_(rounded_box_blocks(sensor)) {
  constexpr std::size_t kFirstPart_bytes = std::size_t{4} << 20;
  slot_cache_.touch(slot_cache_.size_bytes());
  waiting_.touch(kFirstPart_bytes);
  lane_changed_.touch(kFirstPart_bytes);
  lane_shrinking_.touch(kFirstPart_bytes);
  stored_flags_.touch(kFirstPart_bytes);
  changed_.touch(kFirstPart_bytes);
}

void BlockUpdater::begin(const FrameGeometry& frame, bool with_colour, const Kernels& kernels,
                         std::uint32_t frame_number, std::uint32_t chunks, std::uint32_t blocks_per_chunk) {
  frame_ = &frame;
  with_colour_ = with_colour;
  kernels_ = &kernels;
  frame_number_ = frame_number;
  chunks_ = chunks;
  per_chunk_ = blocks_per_chunk;
  assert(chunks <= lanes_.size() && static_cast<std::size_t>(chunks) * blocks_per_chunk <= waiting_.size());
  std::fill_n(lanes_.begin(), chunks, Lane{});
  stored_count_.store(0, std::memory_order_relaxed);
  changed_count_ = 0;
}

void BlockUpdater::wait(std::uint32_t chunk, const Waiting& waiting) {
  waiting_[static_cast<std::size_t>(chunk) * per_chunk_ + lanes_[chunk].waiting++] = waiting;
}

void BlockUpdater::submit_uniform(std::uint32_t chunk, BlockKey key, std::uint32_t slot) {
  if (slot == kNoSlot) {
    wait(chunk, {key, nullptr, kAllFree, slot});
  } else {
    lower_uniform(chunk, slot);
  }
}

void BlockUpdater::lower_uniform(std::uint32_t chunk, std::uint32_t slot) {
  BlockHeader& header = map_->header(slot);
  const std::uint8_t lowered = after_miss(header.uniform_level, steps_);
  if (lowered == header.uniform_level) return;
  header.sequence.fetch_add(1, std::memory_order_acq_rel);
  header.uniform_level = lowered;
  header.changed_frame = frame_number_;
  header.sequence.fetch_add(1, std::memory_order_release);
  lane_changed_[static_cast<std::size_t>(chunk) * per_chunk_ + lanes_[chunk].changed++] = slot;
}

void BlockUpdater::submit(std::uint32_t chunk, BlockKey key, std::uint32_t slot, const FreeFlags* flags,
                          HitRecord* hits) {
  if (hits != nullptr) hits->consumed = 1;
  if (slot != kNoSlot) {
    const BlockHeader& header = map_->header(slot);
    if (hits == nullptr && is_settled(slot)) return;
    if (header.plane != kNoSlot && (hits == nullptr || !with_colour_ || bricks_missing(header, *hits) == 0)) {
      apply_dense(chunk, slot, flags != nullptr ? flags->data() : nullptr, hits);
      return;
    }
  }
  std::uint32_t index = kNoFlags;
  if (flags != nullptr) {
    index = stored_count_.fetch_add(1, std::memory_order_relaxed);
    stored_flags_[index] = *flags;
  }
  wait(chunk, {key, hits, index, slot});
}

std::uint8_t BlockUpdater::bricks_missing(const BlockHeader& header, const HitRecord& hits) const {
  std::uint8_t missing = 0;
  for (std::size_t b = 0; b < kBricksPerBlock; ++b) {
    if (header.bricks[b] != kNoSlot) continue;
    for (std::size_t i = b * kBrickVoxels; i < (b + 1) * kBrickVoxels; i += 8) {
      std::uint64_t eight;
      std::memcpy(&eight, hits.flags.data() + i, sizeof eight);
      if ((eight & 0x0202020202020202ULL) == 0) continue;
      for (std::size_t j = i; j < i + 8; ++j) {
        if ((hits.flags[j] & kColourFlag) == 0) continue;
        const std::uint8_t level =
            header.plane == kNoSlot ? header.uniform_level : map_->plane(header.plane)[j] & kLevelMask;
        if (after_hit(level, steps_) > kUnknownLevel) missing = static_cast<std::uint8_t>(missing | (1U << b));
      }
    }
  }
  return missing;
}

void BlockUpdater::apply_dense(std::uint32_t chunk, std::uint32_t slot, const std::uint8_t* flags,
                               const HitRecord* hits) {
  BlockHeader& header = map_->header(slot);
  LevelPlane& levels = map_->plane(header.plane);
  header.sequence.fetch_add(1, std::memory_order_acq_rel);
  const ApplyResult result =
      kernels_->apply_block({levels.data(), hits != nullptr ? hits->flags.data() : nullptr, flags, steps_});
  bool changed = result.changed;
  if (hits != nullptr && with_colour_) changed |= apply_colours(header, levels, *hits);
  if (changed) header.changed_frame = frame_number_;
  header.sequence.fetch_add(1, std::memory_order_release);
  const std::size_t lane = static_cast<std::size_t>(chunk) * per_chunk_;
  if (changed) lane_changed_[lane + lanes_[chunk].changed++] = slot;
  if (result.all_equal || result.lost_colour != 0) lane_shrinking_[lane + lanes_[chunk].shrinking++] = slot;
}

bool BlockUpdater::apply_colours(BlockHeader& header, LevelPlane& levels, const HitRecord& hits) {
  bool changed = false;
  for (std::size_t i = 0; i < kBlockVoxels; i += 8) {
    std::uint64_t eight;
    std::memcpy(&eight, hits.flags.data() + i, sizeof eight);
    if ((eight & 0x0202020202020202ULL) == 0) continue;
    for (std::size_t place = i; place < i + 8; ++place) {
      if ((hits.flags[place] & kColourFlag) == 0 || (levels[place] & kLevelMask) <= kUnknownLevel) continue;
      const std::uint32_t brick = header.bricks[place / kBrickVoxels];
      if (brick == kNoSlot) continue;  // the colour pool is full: the level counts all the same
      const std::uint32_t fresh = hits.rgb[place];
      std::uint8_t* colour = map_->brick(brick).data() + 3 * (place % kBrickVoxels);
      const bool had_colour = (levels[place] & kHasColourBit) != 0;
      for (int channel = 0; channel < 3; ++channel) {
        const auto seen = static_cast<std::uint8_t>(fresh >> (8 * channel));
        const std::uint8_t next = had_colour ? blend_channel(colour[channel], seen) : seen;
        changed |= next != colour[channel];
        colour[channel] = next;
      }
      changed |= !had_colour;
      levels[place] |= kHasColourBit;
    }
  }
  return changed;
}

bool BlockUpdater::hand_out(Waiting& waiting) {
  const bool is_new = waiting.slot == kNoSlot;
  waiting.slot = map_->find_or_insert(waiting.key);
  if (waiting.slot == kNoSlot) return false;
  BlockHeader& header = map_->header(waiting.slot);
  if (waiting.flags == kAllFree) return true;
  header.sequence.fetch_add(1, std::memory_order_acq_rel);
  const bool dense = map_->make_dense(header);
  bool all_bricks = true;
  if (dense && waiting.hits != nullptr && with_colour_) {
    const std::uint8_t missing = bricks_missing(header, *waiting.hits);
    for (int b = 0; b < kBricksPerBlock; ++b) {
      if (((missing >> b) & 1U) != 0) all_bricks &= map_->make_brick(header, b);
    }
  }
  header.sequence.fetch_add(1, std::memory_order_release);
  if (!dense) {
    if (is_new) map_->erase_block(waiting.key);
    waiting.slot = kNoSlot;
  }
  return dense && all_bricks;
}

std::uint32_t BlockUpdater::finish(ThreadPool& pool) {
  std::uint32_t refused = 0;
  for (std::uint32_t chunk = 0; chunk < chunks_; ++chunk) {
    for (std::uint32_t i = 0; i < lanes_[chunk].waiting; ++i) {
      if (!hand_out(waiting_[static_cast<std::size_t>(chunk) * per_chunk_ + i])) ++refused;
    }
  }
  pool.parallel_for(chunks_, [&](std::uint32_t chunk) {
    for (std::uint32_t i = 0; i < lanes_[chunk].waiting; ++i) {
      const Waiting& waiting = waiting_[static_cast<std::size_t>(chunk) * per_chunk_ + i];
      if (waiting.slot == kNoSlot) continue;
      if (waiting.flags == kAllFree) {
        lower_uniform(chunk, waiting.slot);
      } else {
        apply_dense(chunk, waiting.slot, waiting.flags == kNoFlags ? nullptr : stored_flags_[waiting.flags].data(),
                    waiting.hits);
      }
    }
  });
  for (std::uint32_t chunk = 0; chunk < chunks_; ++chunk) {
    const std::size_t lane = static_cast<std::size_t>(chunk) * per_chunk_;
    std::copy_n(&lane_changed_[lane], lanes_[chunk].changed, changed_.data() + changed_count_);
    changed_count_ += lanes_[chunk].changed;
    for (std::uint32_t i = 0; i < lanes_[chunk].shrinking; ++i) {
      BlockHeader& header = map_->header(lane_shrinking_[lane + i]);
      header.sequence.fetch_add(1, std::memory_order_acq_rel);
      if (!map_->make_uniform_if_equal(header)) map_->release_bricks_without_colour(header);
      header.sequence.fetch_add(1, std::memory_order_release);
    }
  }
  return refused;
}

}  // namespace g3d::mapper::cpu
