// SPDX-License-Identifier: Apache-2.0
// Which blocks a frame may change: those in which something was measured, and those that rays reach. Blocks that are
// wholly free and uniform, most of what a camera sees, are done with here; the others become work items.
#pragma once

#include "mapper/cuda/kernels/block_table.hpp"
#include "mapper/cuda/kernels/visible.hpp"

namespace g3d::mapper::cuda {

[[nodiscard]] constexpr bool walks_rays(FreeBy by) { return by == FreeBy::exact_rays || by == FreeBy::thesis_rays; }

inline G3D_GPU void add_item(const Memory& m, std::uint32_t block_id, std::uint64_t key, std::uint32_t slot,
                             std::uint32_t record, View view, const RayBounds& rays) {
  WorkItem& item = m.items[atomic_add(&m.input->counters.items, 1U)];
  item.block_id = block_id;
  item.slot = slot;
  item.record = record;
  item.view = static_cast<std::uint32_t>(view);
  item.farthest_m = rays.farthest_m;
  item.nearest_m = rays.nearest_m;
  if (slot != kNone) {
    item.old = m.blocks[slot];
    return;
  }
  item.old.key = key;
  item.old.plane = kNone;
  item.old.uniform_level = kUnknownLevel;
  for (int b = 0; b < kBricks; ++b) item.old.bricks[b] = kNone;
}

/// A block whose every voxel was seen through and none hit. False: its voxels have to be looked at.
inline G3D_GPU bool lower_uniform(const FrameParams& f, const Memory& m, std::uint64_t key, std::uint32_t slot) {
  FrameCounters& counters = m.input->counters;
  if (slot == kNone) {
    slot = insert_block(m, key);
    if (slot == kNone) {
      atomic_add(&counters.refused, 1U);
      return true;
    }
  }
  GpuBlock& block = m.blocks[slot];
  if (block.plane != kNone || block.uniform_level > kUnknownLevel) return false;
  const std::uint32_t lowered = after_miss(static_cast<std::uint8_t>(block.uniform_level), steps_of(f));
  if (lowered == block.uniform_level) return true;
  block.uniform_level = lowered;
  m.changed[atomic_add(&counters.changed, 1U)] = slot;
  return true;
}

/// A block of the box that rays reach and in which nothing was measured.
inline G3D_GPU void visit_block(const FrameParams& f, const Memory& m, int bx, int by, int bz, View view,
                                const RayBounds& rays) {
  const std::uint64_t key = block_key_at(f, bx, by, bz);
  const std::uint32_t slot = find_block(m, key);
  if (view == View::all_free && lower_uniform(f, m, key, slot)) return;
  const bool settled = slot != kNone && m.blocks[slot].plane == kNone && m.blocks[slot].uniform_level == 0;
  if (settled) return;
  add_item(m, block_id_at(f, bx, by, bz), key, slot, kNone, view, rays);
}

inline constexpr int kSupersPerTask = kPixelThreads / 64;

/// Four groups of 4x4x4 blocks.
inline G3D_GPU void find_visible(const Block& block, const Memory& m, const FrameParams& f, int task) {
  G3D_GPU_SHARED std::uint32_t views[kSupersPerTask];
  const int count = f.supers[0] * f.supers[1] * f.supers[2];
  block.each([&](int t) {
    const int super = task * kSupersPerTask + t / 64;
    if (t % 64 != 0) return;
    const int row = super / f.supers[0];
    views[t / 64] = static_cast<std::uint32_t>(
        super < count ? decide_super(f, m, super % f.supers[0], row % f.supers[1], row / f.supers[1]) : View::hidden);
  });
  block.each([&](int t) {
    const View view = static_cast<View>(views[t / 64]);
    if (view == View::hidden) return;
    const int super = task * kSupersPerTask + t / 64;
    const int row = super / f.supers[0];
    const int sx = super % f.supers[0];
    const int sy = row % f.supers[1];
    const int sz = row / f.supers[1];
    const int i = t % 64;
    const int bx = 4 * sx + (i & 3);
    const int by = 4 * sy + ((i >> 2) & 3);
    const int bz = 4 * sz + (i >> 4);
    if (bx >= f.blocks[0] || by >= f.blocks[1] || bz >= f.blocks[2]) return;
    if (m.record_of_block[block_id_at(f, bx, by, bz)] != 0) return;  // find_hit_blocks() has it
    RayBounds rays;
    const View found = decide_block(f, m, view, sx, sy, sz, i, rays);
    if (found != View::hidden) visit_block(f, m, bx, by, bz, found, rays);
  });
}

/// Blocks of the box that rays have marked.
inline G3D_GPU void find_marked(const Block& block, const Memory& m, const FrameParams& f, int task) {
  const std::uint32_t count = static_cast<std::uint32_t>(f.blocks[0] * f.blocks[1] * f.blocks[2]);
  block.each([&](int t) {
    const std::uint32_t id = static_cast<std::uint32_t>(task * kPixelThreads + t);
    if (id >= count || m.marked_blocks[id] == 0 || m.record_of_block[id] != 0) return;
    const int row = static_cast<int>(id) / f.blocks[0];
    const std::uint64_t key = block_key_at(f, static_cast<int>(id) % f.blocks[0], row % f.blocks[1], row / f.blocks[1]);
    add_item(m, id, key, find_block(m, key), kNone, View::look, RayBounds{});
  });
}

/// Blocks in which something was measured: all of them, by `workers` blocks of threads.
inline G3D_GPU void find_hit_blocks(const Block& block, const Memory& m, const FrameParams& f, int worker,
                                    int workers) {
  const std::uint32_t count = m.input->counters.records;
  block.each([&](int t) {
    for (std::uint32_t record = static_cast<std::uint32_t>(worker * kPixelThreads + t); record < count;
         record += static_cast<std::uint32_t>(workers * kPixelThreads)) {
      const std::uint32_t id = m.hit_blocks[record];
      const int row = static_cast<int>(id) / f.blocks[0];
      const int bx = static_cast<int>(id) % f.blocks[0];
      const int by = row % f.blocks[1];
      const int bz = row / f.blocks[1];
      View view = View::hidden;
      RayBounds rays;
      if (f.free_by == FreeBy::projection) {
        const View super = decide_super(f, m, bx >> 2, by >> 2, bz >> 2);
        view = decide_block(f, m, super, bx >> 2, by >> 2, bz >> 2, (bx & 3) | (by & 3) << 2 | (bz & 3) << 4, rays);
      } else if (walks_rays(f.free_by) && m.marked_blocks[id] != 0) {
        view = View::look;
      }
      const std::uint64_t key = block_key_at(f, bx, by, bz);
      add_item(m, id, key, find_block(m, key), record, view, rays);
    }
  });
}

}  // namespace g3d::mapper::cuda
