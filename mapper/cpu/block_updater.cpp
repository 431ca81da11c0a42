// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/block_updater.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace g3d::mapper::cpu {
namespace {

// The box in whole groups of 4x4x4 blocks, the unit in which visible blocks are dealt out.
std::size_t rounded_box_blocks(const SensorGeometry& sensor) {
  const std::size_t side = static_cast<std::size_t>(sensor.max_side_blocks + 3) / 4 * 4;
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
      lane_changed_{ReservedArray<std::uint32_t>(rounded_box_blocks(sensor) * 2),
                    ReservedArray<std::uint32_t>(rounded_box_blocks(sensor) * 2)},
      lane_shrinking_{ReservedArray<std::uint32_t>(rounded_box_blocks(sensor) * 2),
                      ReservedArray<std::uint32_t>(rounded_box_blocks(sensor) * 2)},
      stored_flags_(rounded_box_blocks(sensor)),
      lanes_(most_chunks_),
      changed_(rounded_box_blocks(sensor)) {
  constexpr std::size_t kFirstPart_bytes = std::size_t{4} << 20;
  slot_cache_.touch(slot_cache_.size_bytes());
  waiting_.touch(kFirstPart_bytes);
  for (const std::size_t turn : {kFirst, kSecond}) {
    lane_changed_[turn].touch(kFirstPart_bytes);
    lane_shrinking_[turn].touch(kFirstPart_bytes);
  }
  stored_flags_.touch(kFirstPart_bytes);
  changed_.touch(kFirstPart_bytes);
}

void BlockUpdater::begin(const FrameGeometry& frame, bool with_colour, const Kernels& kernels,
                         std::uint32_t frame_number, std::uint32_t chunks, std::uint32_t blocks_per_chunk,
                         bool one_thread) {
  frame_ = &frame;
  with_colour_ = with_colour;
  kernels_ = &kernels;
  frame_number_ = frame_number;
  chunks_ = chunks;
  per_chunk_ = blocks_per_chunk;
  at_once_ = one_thread;
  refused_ = 0;
  assert(chunks <= lanes_.size() && static_cast<std::size_t>(chunks) * blocks_per_chunk <= waiting_.size());
  std::fill_n(lanes_.begin(), chunks, Lane{});
  stored_count_.store(0, std::memory_order_relaxed);
  changed_count_ = 0;
}

void BlockUpdater::wait(std::uint32_t chunk, Waiting waiting, const FreeFlags* flags) {
  if (at_once_) {
    if (!hand_out(waiting)) ++refused_;
    apply_waiting(chunk, waiting, flags);
    return;
  }
  if (flags != nullptr) {
    waiting.flags = stored_count_.fetch_add(1, std::memory_order_relaxed);
    stored_flags_[waiting.flags] = *flags;
  }
  waiting_[lane_start(chunk) + lanes_[chunk].waiting++] = waiting;
}

void BlockUpdater::apply_waiting(std::uint32_t chunk, const Waiting& waiting, const FreeFlags* flags) {
  if (waiting.slot == kNoSlot) return;
  if (waiting.flags == kAllFree) {
    lower_uniform(chunk, waiting.slot, kSecond);
  } else {
    apply_dense(chunk, waiting.slot, flags != nullptr ? flags->data() : nullptr, waiting.hits, kSecond);
  }
}

void BlockUpdater::submit_uniform(std::uint32_t chunk, BlockKey key, std::uint32_t slot) {
  if (slot == kNoSlot) {
    wait(chunk, {key, nullptr, kAllFree, slot}, nullptr);
  } else {
    lower_uniform(chunk, slot, kFirst);
  }
}

void BlockUpdater::lower_uniform(std::uint32_t chunk, std::uint32_t slot, Turn turn) {
  BlockHeader& header = map_->header(slot);
  const std::uint8_t lowered = after_miss(header.uniform_level, steps_);
  if (lowered == header.uniform_level) return;
  header.sequence.fetch_add(1, std::memory_order_acq_rel);
  header.uniform_level = lowered;
  header.changed_frame = frame_number_;
  header.sequence.fetch_add(1, std::memory_order_release);
  lane_changed_[turn][lane_start(chunk) + lanes_[chunk].changed[turn]++] = slot;
}

void BlockUpdater::submit(std::uint32_t chunk, BlockKey key, std::uint32_t slot, const FreeFlags* flags,
                          HitRecord* hits) {
  if (hits != nullptr) {
    hits->consumed = 1;
    if (hits->held_only != 0) {
      if (flags != nullptr) submit_held(chunk, key, slot, *flags, *hits);
      return;
    }
  }
  if (slot != kNoSlot) {
    const BlockHeader& header = map_->header(slot);
    if (hits == nullptr && is_settled(slot)) return;
    if (header.plane != kNoSlot && (hits == nullptr || !with_colour_ || bricks_missing(header, *hits) == 0)) {
      apply_dense(chunk, slot, flags != nullptr ? flags->data() : nullptr, hits, kFirst);
      return;
    }
  }
  wait(chunk, {key, hits, kNoFlags, slot}, flags);
}

// What is only held needs no memory: as if there were no record, and nothing free where it says so.
void BlockUpdater::submit_held(std::uint32_t chunk, BlockKey key, std::uint32_t slot, const FreeFlags& flags,
                               const HitRecord& held) {
  alignas(64) FreeFlags rest;
  std::uint8_t any = 0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    rest[i] = held.flags[i] != 0 ? std::uint8_t{0} : flags[i];
    any |= rest[i];
  }
  if (any != 0) submit(chunk, key, slot, &rest, nullptr);
}

std::uint8_t BlockUpdater::bricks_missing(const BlockHeader& header, const HitRecord& hits) const {
  // A hit leaves a level occupied from this one on: see after_hit().
  const auto least = static_cast<std::uint8_t>(kUnknownLevel - steps_.hit);
  std::uint8_t missing = 0;
  for (std::size_t b = 0; b < kBricksPerBlock; ++b) {
    if (header.bricks[b] != kNoSlot) continue;
    const std::uint8_t* flags = hits.flags.data() + b * kBrickVoxels;
    std::uint8_t found = 0;
    if (header.plane == kNoSlot) {
      if (header.uniform_level < least) return 0;
      for (int i = 0; i < kBrickVoxels; ++i) found |= flags[i];
    } else {
      const std::uint8_t* levels = map_->plane(header.plane).data() + b * kBrickVoxels;
      for (int i = 0; i < kBrickVoxels; ++i) {
        found |= static_cast<std::uint8_t>((levels[i] & kLevelMask) >= least ? flags[i] : 0);
      }
    }
    if ((found & kColourFlag) != 0) missing = static_cast<std::uint8_t>(missing | (1U << b));
  }
  return missing;
}

void BlockUpdater::apply_dense(std::uint32_t chunk, std::uint32_t slot, const std::uint8_t* flags,
                               const HitRecord* hits, Turn turn) {
  BlockHeader& header = map_->header(slot);
  LevelPlane& levels = map_->plane(header.plane);
  header.sequence.fetch_add(1, std::memory_order_acq_rel);
  const ApplyResult result =
      kernels_->apply_block({levels.data(), hits != nullptr ? hits->flags.data() : nullptr, flags, steps_});
  bool changed = result.changed;
  if (hits != nullptr && with_colour_) changed |= apply_colours(header, levels, *hits);
  if (changed) header.changed_frame = frame_number_;
  header.sequence.fetch_add(1, std::memory_order_release);
  Lane& lane = lanes_[chunk];
  if (changed) lane_changed_[turn][lane_start(chunk) + lane.changed[turn]++] = slot;
  if (result.all_equal || result.lost_colour != 0) {
    lane_shrinking_[turn][lane_start(chunk) + lane.shrinking[turn]++] = slot;
  }
}

bool BlockUpdater::apply_colours(BlockHeader& header, LevelPlane& levels, const HitRecord& hits) {
  bool changed = false;
  for (std::size_t i = 0; i < kBlockVoxels; i += 8) {
    std::uint64_t eight;
    std::memcpy(&eight, hits.flags.data() + i, sizeof eight);
    for (std::uint64_t bits = eight & (0x0101010101010101ULL * kColourFlag); bits != 0; bits &= bits - 1) {
      const std::size_t place = i + static_cast<std::size_t>(std::countr_zero(bits)) / 8;
      if ((levels[place] & kLevelMask) <= kUnknownLevel) continue;
      const std::uint32_t brick = header.bricks[place / kBrickVoxels];
      if (brick == kNoSlot) continue;  // the colour pool is full: the level counts all the same
      std::uint8_t* colour = map_->brick(brick).data() + 3 * (place % kBrickVoxels);
      const std::uint32_t fresh = hits.rgb[place] & 0xFFFFFFU;
      const std::uint32_t old = static_cast<std::uint32_t>(colour[0]) | static_cast<std::uint32_t>(colour[1]) << 8 |
                                static_cast<std::uint32_t>(colour[2]) << 16;
      const bool had_colour = (levels[place] & kHasColourBit) != 0;
      const std::uint32_t next = had_colour ? blend_rgb(old, fresh) : fresh;
      changed |= next != old || !had_colour;
      colour[0] = static_cast<std::uint8_t>(next);
      colour[1] = static_cast<std::uint8_t>(next >> 8);
      colour[2] = static_cast<std::uint8_t>(next >> 16);
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
  for (std::uint32_t chunk = 0; chunk < chunks_; ++chunk) {
    for (std::uint32_t i = 0; i < lanes_[chunk].waiting; ++i) {
      if (!hand_out(waiting_[lane_start(chunk) + i])) ++refused_;
    }
  }
  if (!at_once_) {
    pool.parallel_for(chunks_, [&](std::uint32_t chunk) {
      for (std::uint32_t i = 0; i < lanes_[chunk].waiting; ++i) {
        const Waiting& waiting = waiting_[lane_start(chunk) + i];
        const bool has_flags = waiting.flags != kAllFree && waiting.flags != kNoFlags;
        apply_waiting(chunk, waiting, has_flags ? &stored_flags_[waiting.flags] : nullptr);
      }
    });
  }
  for (std::uint32_t chunk = 0; chunk < chunks_; ++chunk) {
    for (const std::size_t turn : {kFirst, kSecond}) {
      const std::uint32_t count = lanes_[chunk].changed[turn];
      std::copy_n(&lane_changed_[turn][lane_start(chunk)], count, changed_.data() + changed_count_);
      changed_count_ += count;
      for (std::uint32_t i = 0; i < lanes_[chunk].shrinking[turn]; ++i) {
        BlockHeader& header = map_->header(lane_shrinking_[turn][lane_start(chunk) + i]);
        header.sequence.fetch_add(1, std::memory_order_acq_rel);
        if (!map_->make_uniform_if_equal(header)) map_->release_bricks_without_colour(header);
        header.sequence.fetch_add(1, std::memory_order_release);
      }
    }
  }
  return refused_;
}

}  // namespace g3d::mapper::cpu
