// SPDX-License-Identifier: Apache-2.0
// Which blocks a frame may change: those in which something was measured, and those that rays reach. Blocks that are
// wholly free and uniform, most of what a camera sees, are done with here; the others become work items. One warp looks
// at 32 blocks.
#pragma once

#include "mapper/cuda/kernels/block_table.hpp"
#include "mapper/cuda/kernels/projection.hpp"

namespace g3d::mapper::cuda {

using Warp = Team<1>;
template <typename T>
using PerLane = PerThread<T, 32>;

/// A block of the box and what is known of it.
struct FoundBlock {
  std::int32_t bx, by, bz;
  View view;
  std::uint32_t record;  ///< index + 1; 0: nothing was measured in it
  RayBounds rays;
  std::uint32_t slot;
  std::uint32_t plane;
  std::uint32_t uniform_level;
};

/// Looks a block up in the map, if the frame may change it.
inline G3D_GPU void look_up(const FrameParams& f, const Memory& m, FoundBlock& b) {
  b.slot = kNone;
  b.plane = kNone;
  b.uniform_level = kUnknownLevel;
  if (b.view == View::hidden && b.record == 0) return;
  b.slot = find_block(m, block_key_at(f, b.bx, b.by, b.bz));
  if (b.slot == kNone) return;
  b.plane = m.blocks[b.slot].plane;
  b.uniform_level = m.blocks[b.slot].uniform_level;
}

using FoundBlocks = PerThread<FoundBlock, kPixelThreads>;

/// Items of a block of threads, until all of them together have decided about the items' bricks.
struct ItemBricks {
  ListShares lists;
  std::uint32_t where[kPixelThreads];
  View view[kPixelThreads];
  float farthest_m[kPixelThreads];  ///< see RayBounds
  float nearest_m[kPixelThreads];
};

/// View and window of one brick of an item.
inline G3D_GPU std::uint32_t choose_brick(const FrameParams& f, const Memory& m, const TopLevels& top,
                                          const ItemBricks& s, int item, int brick) {
  View view = s.view[item];
  if (f.free_by != FreeBy::projection) return static_cast<std::uint32_t>(view);
  const std::uint32_t where = s.where[item];
  const Corner corner = corner_of(f, static_cast<int>(where & 1023U), static_cast<int>(where >> 10 & 1023U),
                                  static_cast<int>(where >> 20));
  if (view == View::look || view == View::look_at_border) {
    view = decide_brick(f, m, top, corner, {s.farthest_m[item], s.nearest_m[item]}, brick);
  }
  return static_cast<std::uint32_t>(view) | choose_window(f, f.units_per_metre * corner.z_m + f.middle_units[brick])
                                                << 2;
}

/// What becomes of the blocks that the threads have found.
inline G3D_GPU void settle_blocks(const Block& block, const Memory& m, const FrameParams& f, const TopLevels& top,
                                  FoundBlocks& found) {
  G3D_GPU_SHARED ItemBricks s;
  FrameCounters& counters = m.input->counters;
  const std::uint32_t share_number = static_cast<std::uint32_t>(block.index) % kShares;
  GpuPool& share = m.state->blocks.shares[share_number];
  PerThread<std::uint32_t, kPixelThreads> wants[2];  // a new block; to be an item
  PerThread<std::uint32_t, kPixelThreads> places[2];
  PerThread<std::uint32_t, kPixelThreads> changes[1];
  PerThread<std::uint32_t, kPixelThreads> changed_places[1];
  block.lanes([&](int t) {
    const FoundBlock& b = found[t];
    // Every voxel was seen through and none hit: a uniform block stays one.
    const bool lowers =
        b.view == View::all_free && b.record == 0 && b.plane == kNone && b.uniform_level <= kUnknownLevel;
    // Nothing can change in it; but marks of rays have to be taken away, or they would count for a later frame's box.
    const bool settled = b.slot != kNone && b.plane == kNone && b.uniform_level == 0 && f.free_by == FreeBy::projection;
    wants[0][t] = lowers && b.slot == kNone ? 1 : 0;
    wants[1][t] = b.record != 0 || (b.view != View::hidden && !lowers && !settled) ? 1 : 0;
    changes[0][t] = lowers && !settled ? 1 : 0;
    if (lowers && !settled && b.slot != kNone) {
      m.blocks[b.slot].uniform_level = after_miss(static_cast<std::uint8_t>(b.uniform_level), steps_of(f));
    }
  });
  append<2>(block, s.lists, wants, {&share.taken, &counters.items}, places);
  block.each([&](int t) {
    FoundBlock& b = found[t];
    if (wants[1][t] != 0) {
      WorkItem& item = m.items[places[1][t]];
      item.where = static_cast<std::uint32_t>(b.bx | b.by << 10 | b.bz << 20);
      item.slot = b.slot;
      item.record = b.record - 1;  // kNone for 0
      item.view = static_cast<std::uint32_t>(b.view);
      item.plane = b.plane;
      item.uniform_level = b.uniform_level;
      const std::uint32_t here = places[1][t] - s.lists.first[1][0];
      s.where[here] = item.where;
      s.view[here] = b.view;
      s.farthest_m[here] = b.rays.farthest_m;
      s.nearest_m[here] = b.rays.nearest_m;
    }
    if (wants[0][t] == 0) return;
    b.slot = slot_of(start_of(share), m.free_blocks, places[0][t]);
    if (b.slot == kNone) b.slot = take(m.state->blocks, m.free_blocks, share_number + 1);
    if (b.slot == kNone) {
      changes[0][t] = 0;
      atomic_add(&counters.refused, 1U);
      return;
    }
    write_new_block(m, block_key_at(f, b.bx, b.by, b.bz), b.slot, after_miss(kUnknownLevel, steps_of(f)));
  });
  // Eight threads for each item.
  block.each([&](int t) {
    int count = 0;
    for (const std::uint32_t wanted : s.lists.wanted[1]) count += static_cast<int>(wanted);
    for (int i = t; i < kBricks * count; i += kPixelThreads) {
      WorkItem& item = m.items[s.lists.first[1][0] + static_cast<std::uint32_t>(i / kBricks)];
      reinterpret_cast<std::uint8_t*>(item.choices)[i % kBricks] =
          static_cast<std::uint8_t>(choose_brick(f, m, top, s, i / kBricks, i % kBricks));
    }
  });
  append<1>(block, s.lists, changes, {&counters.changed}, changed_places);
  block.each([&](int t) {
    if (changes[0][t] != 0) m.changed[changed_places[0][t]] = found[t].slot;
  });
}

/// Half of a group of 4x4x4 blocks.
inline G3D_GPU void find_visible(const Warp& warp, const Memory& m, const FrameParams& f, const TopLevels& top,
                                 int task, PerLane<FoundBlock>& found) {
  const int super = task / 2;
  const int row = super / f.supers[0];
  const int sx = super % f.supers[0];
  const int sy = row % f.supers[1];
  const int sz = row / f.supers[1];
  const Corner first = corner_of(f, 4 * sx, 4 * sy, 4 * sz);
  const float z_m = first.z_m + f.super_middle_m[2];
  const BoxBound box = bound_box(f.super_view, first.x_m + f.super_middle_m[0], first.y_m + f.super_middle_m[1], z_m);
  PerLane<std::uint32_t> ends;
  PerLane<std::uint32_t> own;
  warp.lanes([&](int t) {
    const int i = task % 2 * 32 + t;
    FoundBlock& b = found[t];
    b.bx = 4 * sx + (i & 3);
    b.by = 4 * sy + ((i >> 2) & 3);
    b.bz = 4 * sz + (i >> 4);
    const bool exists = b.bx < f.blocks[0] && b.by < f.blocks[1] && b.bz < f.blocks[2];
    b.record = exists ? m.record_of_block[block_id_at(f, b.bx, b.by, b.bz)] : 0;
    b.rays = {};
    b.view = exists ? View::look : View::hidden;
    gather_box<32>(f, m, top, box, t, ends[t], own[t]);
  });
  join_shares<32>(warp, ends, own);
  warp.lanes([&](int t) {
    FoundBlock& b = found[t];
    if (b.view != View::hidden) {
      b.view = conclude(f, f.super_view, false, box, ends[t], own[t], z_m, b.rays);
      if (b.view == View::hidden || b.view == View::all_free) {
        b.rays = {};
      } else {
        b.view = decide_block(f, m, top, first, task % 2 * 32 + t, b.rays);
      }
    }
  });
}

/// Blocks of the box that rays have marked or in which something was measured.
inline G3D_GPU void find_marked(const Warp& warp, const Memory& m, const FrameParams& f, int task,
                                PerLane<FoundBlock>& found) {
  const int count = f.blocks[0] * f.blocks[1] * f.blocks[2];
  warp.lanes([&](int t) {
    const int id = task * 32 + t;
    const bool exists = id < count;
    const int row = id / f.blocks[0];
    FoundBlock& b = found[t];
    b.bx = id % f.blocks[0];
    b.by = row % f.blocks[1];
    b.bz = row / f.blocks[1];
    b.record = exists ? m.record_of_block[id] : 0;
    b.view = exists && walks_rays(f.free_by) && m.marked_blocks[id] != 0 ? View::look : View::hidden;
    b.rays = {};
  });
}

/// Tasks of one warp each.
inline G3D_GPU int find_tasks(const FrameParams& f) {
  if (f.free_by == FreeBy::projection) return 2 * f.supers[0] * f.supers[1] * f.supers[2];
  return tiles(f.blocks[0] * f.blocks[1] * f.blocks[2], 32);
}

inline constexpr int kWarpsTogether = kPixelThreads / 32;

/// Tasks of `together` warps; all threads of the block settle what these have found.
inline G3D_GPU void find_blocks(const Block& block, const Memory& m, const FrameParams& f, const TopLevels& top,
                                int task, int together) {
  FoundBlocks found;
  block.teams<1>([&](const Warp& warp) {
    PerLane<FoundBlock> own;
    const int number = task * together + warp.in_block;
    warp.lanes([&](int t) { own[t] = {0, 0, 0, View::hidden, 0, {}, kNone, kNone, kUnknownLevel}; });
    if (warp.in_block < together && number < find_tasks(f)) {
      if (f.free_by == FreeBy::projection) {
        find_visible(warp, m, f, top, number, own);
      } else {
        find_marked(warp, m, f, number, own);
      }
    }
    warp.lanes([&](int t) {
      look_up(f, m, own[t]);
      found[32 * warp.in_block + t] = own[t];
    });
  });
  settle_blocks(block, m, f, top, found);
}

}  // namespace g3d::mapper::cuda
