// SPDX-License-Identifier: Apache-2.0
// Evidence of one frame -> levels and colours of the map. What needs no new memory is applied at once, by many threads,
// each block by one of them; blocks, planes and bricks that are missing are handed out afterwards by one thread in a
// fixed order, so that a map does not depend on the number of threads even when a pool runs full. A single thread
// offers in just that order, so it gets its memory at once.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "mapper/cpu/frame_geometry.hpp"
#include "mapper/cpu/hit_scatter.hpp"
#include "mapper/cpu/kernels/kernels.hpp"
#include "mapper/cpu/thread_pool.hpp"
#include "mapper/pool.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper::cpu {

using FreeFlags = std::array<std::uint8_t, kBlockVoxels>;  ///< 0, kWeakFree or kStrongFree by place

class BlockUpdater {
 public:
  BlockUpdater(VoxelMap& map, const SensorGeometry& sensor, UpdateSteps steps);

  /// `chunks` lanes of at most `blocks_per_chunk` blocks will be offered. `one_thread`: by a single thread, lane after
  /// lane.
  void begin(const FrameGeometry& frame, bool with_colour, const Kernels& kernels, std::uint32_t frame_number,
             std::uint32_t chunks, std::uint32_t blocks_per_chunk, bool one_thread);

  /// Slot of a block if it is remembered from a recent frame, else kNoSlot. A camera sees the same blocks again and
  /// again, and the hash table's random reads would cost more than the update itself.
  [[nodiscard]] std::uint32_t remembered_slot(BlockKey key) const {
    const std::uint32_t guess =
        std::atomic_ref<std::uint32_t>(slot_cache_[key & slot_cache_mask_]).load(std::memory_order_relaxed);
    return guess < map_->slot_end() && map_->header(guess).key == key ? guess : kNoSlot;
  }
  /// Slot of a block, kNoSlot if the map has none.
  [[nodiscard]] std::uint32_t slot_of(BlockKey key) {
    std::uint32_t slot = remembered_slot(key);
    if (slot != kNoSlot) return slot;
    slot = map_->find(key);
    if (slot != kNoSlot) {
      std::atomic_ref<std::uint32_t>(slot_cache_[key & slot_cache_mask_]).store(slot, std::memory_order_relaxed);
    }
    return slot;
  }

  /// Would being seen through change nothing in this block? Most of what a robot looks at is known to be free already.
  [[nodiscard]] bool is_settled(std::uint32_t slot) const {
    return slot != kNoSlot && map_->header(slot).plane == kNoSlot && map_->header(slot).uniform_level == 0;
  }

  /// The 512 levels of a dense block, nullptr if there is no such block or it is uniform.
  [[nodiscard]] const std::uint8_t* levels_of(std::uint32_t slot) const {
    if (slot == kNoSlot || map_->header(slot).plane == kNoSlot) return nullptr;
    return map_->plane(map_->header(slot).plane).data();
  }

  /// Brings the header of a remembered block closer.
  void prefetch_header(BlockKey key) const {
    const std::uint32_t guess =
        std::atomic_ref<std::uint32_t>(slot_cache_[key & slot_cache_mask_]).load(std::memory_order_relaxed);
    if (guess < map_->slot_end()) __builtin_prefetch(&map_->header(guess));
  }
  /// Brings closer what an update of this block will touch, while others are computed.
  void prefetch(BlockKey key, std::uint32_t slot, const HitRecord* hits) const {
    for (int line = 0; hits != nullptr && line < kBlockVoxels; line += 64) {
      __builtin_prefetch(hits->flags.data() + line);
    }
    if (slot == kNoSlot) {
      map_->prefetch(key);
      return;
    }
    const std::uint8_t* levels = levels_of(slot);
    for (int line = 0; levels != nullptr && line < kBlockVoxels; line += 64) __builtin_prefetch(levels + line, 1);
    if (hits == nullptr) return;
    for (const std::uint32_t brick : map_->header(slot).bricks) {
      if (brick == kNoSlot) continue;
      const std::uint8_t* colours = map_->brick(brick).data();
      for (int line = 0; line < 3 * kBrickVoxels; line += 64) __builtin_prefetch(colours + line, 1);
    }
  }

  /// A block whose every voxel was seen through. `is_strong(place)` is asked for occupied voxels only.
  template <typename IsStrong>
  void offer_all_free(std::uint32_t chunk, BlockKey key, HitRecord* hits, IsStrong&& is_strong) {
    const std::uint32_t slot = slot_of(key);
    if (hits == nullptr && (slot == kNoSlot || map_->header(slot).plane == kNoSlot)) {
      offer_uniform(chunk, key, slot, is_strong);
      return;
    }
    alignas(64) FreeFlags flags;
    flags.fill(kWeakFree);
    offer(chunk, key, slot, flags, hits, is_strong);
  }

  /// A block with some voxels seen through. `flags` may be changed.
  template <typename IsStrong>
  void offer_some_free(std::uint32_t chunk, BlockKey key, FreeFlags& flags, HitRecord* hits, IsStrong&& is_strong) {
    offer(chunk, key, slot_of(key), flags, hits, is_strong);
  }

  /// A block with hits alone.
  void offer_hits(std::uint32_t chunk, BlockKey key, HitRecord& hits) {
    submit(chunk, key, slot_of(key), nullptr, &hits);
  }

  /// Hands out memory, applies what waited for it, gives back what is no longer needed. Returns refused blocks.
  std::uint32_t finish(ThreadPool& pool);

  [[nodiscard]] std::uint32_t chunks() const { return chunks_; }
  [[nodiscard]] std::span<const std::uint32_t> changed_slots() const { return {changed_.data(), changed_count_}; }

 private:
  struct Waiting {
    BlockKey key;
    HitRecord* hits;
    std::uint32_t flags;  ///< index of stored free flags, kAllFree, or kNoFlags
    std::uint32_t slot;
  };
  static constexpr std::uint32_t kNoFlags = 0xFFFFFFFFU;
  static constexpr std::uint32_t kAllFree = 0xFFFFFFFEU;
  /// Blocks that had their memory come first in every list, those that had to be given some second: the same order
  /// whether they waited for it or not.
  enum Turn : std::size_t { kFirst, kSecond };
  struct Lane {
    std::uint32_t waiting = 0;
    std::array<std::uint32_t, 2> changed{};
    std::array<std::uint32_t, 2> shrinking{};
  };

  template <typename IsStrong>
  void offer(std::uint32_t chunk, BlockKey key, std::uint32_t slot, FreeFlags& flags, HitRecord* hits,
             IsStrong&& is_strong) {
    if (slot != kNoSlot) settle_contested(slot, flags, hits, is_strong);
    submit(chunk, key, slot, &flags, hits);
  }

  template <typename IsStrong>
  void offer_uniform(std::uint32_t chunk, BlockKey key, std::uint32_t slot, IsStrong&& is_strong) {
    if (slot != kNoSlot && map_->header(slot).uniform_level > kUnknownLevel) {
      alignas(64) FreeFlags flags;
      flags.fill(kWeakFree);
      offer(chunk, key, slot, flags, nullptr, is_strong);
      return;
    }
    submit_uniform(chunk, key, slot);
  }

  /// Occupied voxels give way to measured rays only.
  template <typename IsStrong>
  void settle_contested(std::uint32_t slot, FreeFlags& flags, const HitRecord* hits, IsStrong&& is_strong) {
    const BlockHeader& header = map_->header(slot);
    if (header.plane == kNoSlot) {
      if (header.uniform_level <= kUnknownLevel) return;
      for (std::size_t i = 0; i < flags.size(); ++i) {
        if (flags[i] == kWeakFree && is_strong(static_cast<int>(i))) flags[i] = kStrongFree;
      }
      return;
    }
    const LevelPlane& levels = map_->plane(header.plane);
    const std::uint8_t* hit_flags = hits != nullptr ? hits->flags.data() : kNoHits.data();
    if (!kernels_->any_contested(levels.data(), hit_flags, flags.data())) return;
    for (std::size_t i = 0; i < flags.size(); i += 8) {
      std::uint64_t level, hit, free;
      std::memcpy(&level, levels.data() + i, sizeof level);
      std::memcpy(&hit, hit_flags + i, sizeof hit);
      std::memcpy(&free, flags.data() + i, sizeof free);
      // The highest bit of each byte: the level is above kUnknownLevel, the voxel kWeakFree, not hit and not held.
      constexpr std::uint64_t kEach = 0x0101010101010101ULL;
      const std::uint64_t occupied = (level & kEach * kLevelMask) + kEach * (0x7F - kUnknownLevel);
      const std::uint64_t strong_or_hit =
          (free & kEach * 2) << 6 | (hit & kEach * kHitFlag) << 7 | (hit & kEach * kHeldFlag) << 5;
      for (std::uint64_t contested = occupied & (free & kEach) << 7 & ~strong_or_hit & kEach * 0x80; contested != 0;
           contested &= contested - 1) {
        const std::size_t place = i + static_cast<std::size_t>(std::countr_zero(contested)) / 8;
        if (is_strong(static_cast<int>(place))) flags[place] = kStrongFree;
      }
    }
  }

  void submit_uniform(std::uint32_t chunk, BlockKey key, std::uint32_t slot);
  void submit(std::uint32_t chunk, BlockKey key, std::uint32_t slot, const FreeFlags* flags, HitRecord* hits);
  /// Nothing was hit in the block, and its held voxels stay as they are.
  void submit_held(std::uint32_t chunk, BlockKey key, std::uint32_t slot, const FreeFlags& flags,
                   const HitRecord& held);
  void wait(std::uint32_t chunk, Waiting waiting, const FreeFlags* flags);
  /// After hand_out().
  void apply_waiting(std::uint32_t chunk, const Waiting& waiting, const FreeFlags* flags);
  void lower_uniform(std::uint32_t chunk, std::uint32_t slot, Turn turn);
  void apply_dense(std::uint32_t chunk, std::uint32_t slot, const std::uint8_t* flags, const HitRecord* hits,
                   Turn turn);
  [[nodiscard]] std::size_t lane_start(std::uint32_t chunk) const {
    return static_cast<std::size_t>(chunk) * per_chunk_;
  }
  [[nodiscard]] bool apply_colours(BlockHeader& header, LevelPlane& levels, const HitRecord& hits);
  [[nodiscard]] std::uint8_t bricks_missing(const BlockHeader& header, const HitRecord& hits) const;
  [[nodiscard]] bool hand_out(Waiting& waiting);

  static constexpr FreeFlags kNoHits{};

  VoxelMap* map_;
  UpdateSteps steps_;
  const FrameGeometry* frame_ = nullptr;
  bool with_colour_ = false;
  const Kernels* kernels_ = nullptr;
  std::uint32_t frame_number_ = 0;
  std::uint32_t chunks_ = 0;
  std::uint32_t per_chunk_ = 0;
  bool at_once_ = false;
  std::uint32_t refused_ = 0;
  std::size_t most_chunks_;
  std::uint64_t slot_cache_mask_;
  mutable ReservedArray<std::uint32_t> slot_cache_;  ///< by the low bits of the key: a cube of blocks that wraps around
  ReservedArray<Waiting> waiting_;
  std::array<ReservedArray<std::uint32_t>, 2> lane_changed_;
  std::array<ReservedArray<std::uint32_t>, 2> lane_shrinking_;
  ReservedArray<FreeFlags> stored_flags_;
  std::atomic<std::uint32_t> stored_count_{0};
  std::vector<Lane> lanes_;
  ReservedArray<std::uint32_t> changed_;
  std::size_t changed_count_ = 0;
};

}  // namespace g3d::mapper::cpu
