// SPDX-License-Identifier: Apache-2.0
// The map's hash table and pools, for many threads at once. In one launch each block is looked for, made or forgotten
// by one thread alone; only places in the table and slots are contended for.
#pragma once

#include "mapper/cuda/kernels/common.hpp"

namespace g3d::mapper::cuda {

[[nodiscard]] constexpr std::uint32_t home_of(std::uint64_t key, std::uint32_t mask) {
  key *= 0x9E3779B97F4A7C15ULL;
  return static_cast<std::uint32_t>(key ^ (key >> 32)) & mask;
}

inline G3D_GPU std::uint32_t find_block(const Memory& m, std::uint64_t key) {
  const std::uint32_t mask = m.table_mask;
  std::uint32_t place = home_of(key, mask);
  for (std::uint32_t probes = 0; probes <= mask; ++probes) {
    const std::uint64_t stored = m.table_keys[place];
    if (stored == key + 1) return m.table_slots[place];
    if (stored == 0) return kNone;
    place = (place + 1) & mask;
  }
  return kNone;
}

/// A share of a pool as it was tidied up: its numbers stay the same until the next frame.
struct ShareStart {
  std::uint32_t on_stack;
  std::uint32_t high_water;
  std::uint32_t first;
  std::uint32_t end;
};
inline G3D_GPU ShareStart start_of(const GpuPool& share) {
  return {share.free_count, share.high_water, share.first, share.first + share.capacity};
}

/// The `taken`-th slot since then, kNone if there is none.
inline G3D_GPU std::uint32_t slot_of(const ShareStart& share, const std::uint32_t* free_slots, std::uint32_t taken) {
  if (taken < share.on_stack) return free_slots[share.first + share.on_stack - 1 - taken];
  const std::uint32_t fresh = taken - share.on_stack;
  return fresh < share.end - share.high_water ? share.high_water + fresh : kNone;
}

/// From share `number`, or the next one that has a slot. kNone when all are empty.
inline G3D_GPU std::uint32_t take(GpuPools& pools, const std::uint32_t* free_slots, std::uint32_t number) {
  for (std::uint32_t i = 0; i < kShares; ++i) {
    GpuPool& share = pools.shares[(number + i) % kShares];
    const ShareStart start = start_of(share);  // read first: one wait with the other
    const std::uint32_t slot = slot_of(start, free_slots, atomic_add(&share.taken, 1U));
    if (slot != kNone) return slot;
  }
  return kNone;
}

inline G3D_GPU void give_back(GpuPools& pools, std::uint32_t* returned, std::uint32_t slot) {
  GpuPool& share = pools.shares[slot / pools.share_size];
  returned[share.first + atomic_add(&share.returned_count, 1U)] = slot;
}

/// How many of a share's slots are left on its stack.
inline G3D_GPU std::uint32_t left_on_stack(const GpuPool& share) {
  return share.free_count - least(share.taken, share.free_count);
}

inline G3D_GPU void settle_share(GpuPool& share) {
  const std::uint32_t left = left_on_stack(share);
  const std::uint32_t fresh = share.taken - (share.free_count - left);
  share.high_water += least(fresh, share.first + share.capacity - share.high_water);
  share.free_count = left + share.returned_count;
  share.returned_count = 0;
  share.taken = 0;
}

inline constexpr int kTidyTasks = 3 * static_cast<int>(kShares);

/// Takes off what was taken from one share and puts what was given back onto its stack. In a launch that does neither.
template <int kThreads>
inline G3D_GPU void tidy_share(const Block& block, const Memory& m, int task) {
  MapState& s = *m.state;
  const int kind = task / static_cast<int>(kShares);
  GpuPool& share = (kind == 0 ? s.blocks : kind == 1 ? s.planes : s.bricks).shares[task % static_cast<int>(kShares)];
  block.each([&](int t) {
    std::uint32_t* to = (kind == 0   ? m.free_blocks
                         : kind == 1 ? m.free_planes
                                     : m.free_bricks) +
                        share.first + left_on_stack(share);
    const std::uint32_t* from = (kind == 0   ? m.returned_blocks
                                 : kind == 1 ? m.returned_planes
                                             : m.returned_bricks) +
                                share.first;
    const std::uint32_t count = share.returned_count;
    for (std::uint32_t i = static_cast<std::uint32_t>(t); i < count; i += kThreads) to[i] = from[i];
  });
  block.each([&](int t) {
    if (t == 0) settle_share(share);
  });
}

/// Makes find_block() find it. It must not be in the map.
inline G3D_GPU void enter_table(const Memory& m, std::uint64_t key, std::uint32_t slot) {
  const std::uint32_t mask = m.table_mask;
  // At most half of the table is in use: this ends.
  for (std::uint32_t place = home_of(key, mask);; place = (place + 1) & mask) {
    std::uint64_t stored = atomic_cas(m.table_keys + place, std::uint64_t{0}, key + 1);
    if (stored == kForgotten && atomic_cas(m.table_keys + place, kForgotten, key + 1) == kForgotten) stored = 0;
    if (stored != 0) continue;
    m.table_slots[place] = slot;
    return;
  }
}

/// A uniform block that is not in the map yet.
inline G3D_GPU void write_new_block(const Memory& m, std::uint64_t key, std::uint32_t slot, std::uint32_t level) {
  GpuBlock& fresh = m.blocks[slot];
  fresh.key = key;
  fresh.plane = kNone;
  fresh.uniform_level = level;
  for (int b = 0; b < kBricks; ++b) fresh.bricks[b] = kNone;
  enter_table(m, key, slot);
}

/// A new block, uniform unknown; it must not be in the map. kNone when the pool is full.
inline G3D_GPU std::uint32_t insert_block(const Memory& m, std::uint64_t key, std::uint32_t share) {
  const std::uint32_t slot = take(m.state->blocks, m.free_blocks, share);
  if (slot != kNone) write_new_block(m, key, slot, kUnknownLevel);
  return slot;
}

/// Its former place in the table, kNone if it was not in the map.
inline G3D_GPU std::uint32_t erase_block(const Memory& m, std::uint64_t key) {
  const std::uint32_t mask = m.table_mask;
  std::uint32_t place = home_of(key, mask);
  for (std::uint32_t probes = 0; probes <= mask && m.table_keys[place] != key + 1; ++probes) {
    if (m.table_keys[place] == 0) return kNone;
    place = (place + 1) & mask;
  }
  if (m.table_keys[place] != key + 1) return kNone;
  const std::uint32_t slot = m.table_slots[place];
  m.table_keys[place] = kForgotten;
  GpuBlock& gone = m.blocks[slot];
  if (gone.plane != kNone) give_back(m.state->planes, m.returned_planes, gone.plane);
  for (int b = 0; b < kBricks; ++b) {
    if (gone.bricks[b] != kNone) give_back(m.state->bricks, m.returned_bricks, gone.bricks[b]);
  }
  gone.key = kForgotten;
  give_back(m.state->blocks, m.returned_blocks, slot);
  return place;
}

/// The same in a launch that makes no blocks. Where a search would end behind the place anyway it becomes an empty one
/// again, and the forgotten ones before it: a map that follows the robot would fill the table with them, and searches
/// would never end before they have seen all of it.
inline G3D_GPU void forget_block(const Memory& m, std::uint64_t key) {
  std::uint32_t place = erase_block(m, key);
  if (place == kNone || m.table_keys[(place + 1) & m.table_mask] != 0) return;
  while (atomic_cas(m.table_keys + place, kForgotten, std::uint64_t{0}) == kForgotten) {
    place = (place - 1) & m.table_mask;
  }
}

}  // namespace g3d::mapper::cuda
