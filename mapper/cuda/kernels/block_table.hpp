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
  const std::uint32_t mask = m.state->table_mask;
  std::uint32_t place = home_of(key, mask);
  for (std::uint32_t probes = 0; probes <= mask; ++probes) {
    const std::uint64_t stored = m.table_keys[place];
    if (stored == key + 1) return m.table_slots[place];
    if (stored == 0) return kNone;
    place = (place + 1) & mask;
  }
  return kNone;
}

/// kNone when the pool is full.
inline G3D_GPU std::uint32_t take(GpuPool& pool, const std::uint32_t* free_slots) {
  if (*static_cast<volatile std::int32_t*>(&pool.free_count) > 0) {
    const std::int32_t left = atomic_add(&pool.free_count, -1);
    if (left > 0) return free_slots[left - 1];
    atomic_add(&pool.free_count, 1);
  }
  const std::uint32_t next = atomic_add(&pool.high_water, 1U);
  if (next < pool.capacity) return next;
  atomic_add(&pool.high_water, 0xFFFFFFFFU);
  return kNone;
}

inline G3D_GPU void give_back(GpuPool& pool, std::uint32_t* returned, std::uint32_t slot) {
  returned[atomic_add(&pool.returned_count, 1U)] = slot;
}

/// Puts what earlier launches gave back onto the stack. In a launch that takes nothing, by one block of threads.
inline G3D_GPU void collect_returned(const Block& block, GpuPool& pool, std::uint32_t* free_slots,
                                     const std::uint32_t* returned, int threads) {
  const std::uint32_t count = pool.returned_count;
  const std::int32_t before = pool.free_count;
  block.each([&](int t) {
    for (std::uint32_t i = static_cast<std::uint32_t>(t); i < count; i += static_cast<std::uint32_t>(threads)) {
      free_slots[static_cast<std::uint32_t>(before) + i] = returned[i];
    }
  });
  block.each([&](int t) {
    if (t != 0) return;
    pool.free_count = before + static_cast<std::int32_t>(count);
    pool.returned_count = 0;
  });
}

/// A new block, uniform unknown; it must not be in the map. kNone when the pool is full.
inline G3D_GPU std::uint32_t insert_block(const Memory& m, std::uint64_t key) {
  const std::uint32_t slot = take(m.state->blocks, m.free_blocks);
  if (slot == kNone) return kNone;
  GpuBlock& fresh = m.blocks[slot];
  fresh.key = key;
  fresh.plane = kNone;
  fresh.uniform_level = kUnknownLevel;
  for (int b = 0; b < kBricks; ++b) fresh.bricks[b] = kNone;
  const std::uint32_t mask = m.state->table_mask;
  for (std::uint32_t place = home_of(key, mask);; place = (place + 1) & mask) {
    const std::uint64_t stored = *static_cast<volatile std::uint64_t*>(m.table_keys + place);
    if (stored != 0 && stored != kForgotten) continue;  // at most half full: this ends
    if (atomic_cas(m.table_keys + place, stored, key + 1) != stored) continue;
    m.table_slots[place] = slot;
    return slot;
  }
}

inline G3D_GPU void erase_block(const Memory& m, std::uint64_t key) {
  const std::uint32_t mask = m.state->table_mask;
  std::uint32_t place = home_of(key, mask);
  for (std::uint32_t probes = 0; probes <= mask && m.table_keys[place] != key + 1; ++probes) {
    if (m.table_keys[place] == 0) return;
    place = (place + 1) & mask;
  }
  if (m.table_keys[place] != key + 1) return;
  const std::uint32_t slot = m.table_slots[place];
  m.table_keys[place] = kForgotten;
  GpuBlock& gone = m.blocks[slot];
  if (gone.plane != kNone) give_back(m.state->planes, m.returned_planes, gone.plane);
  for (int b = 0; b < kBricks; ++b) {
    if (gone.bricks[b] != kNone) give_back(m.state->bricks, m.returned_bricks, gone.bricks[b]);
  }
  gone.key = kForgotten;
  give_back(m.state->blocks, m.returned_blocks, slot);
}

}  // namespace g3d::mapper::cuda
