// SPDX-License-Identifier: Apache-2.0
// The launches of one frame, in order. Each does several things that do not depend on one another, dealt out to its
// blocks of threads, since at these sizes the gaps between launches cost as much as the work:
//
//   import_blocks    what the host changed since the last frame (only if it did)
//   read_image       ray ends, their minima and maxima | blocks with hits are numbered | pools are tidied up
//   walk_image       rays mark the box (dda and bresenham alone)
//   find_work        blocks that rays reach or have marked, blocks with hits | pixels to hit records | window images
//   update_map       levels and colours
//   export_classes   counters and the changed blocks' classes to the host, which waits for them
//   export_blocks    changed blocks to the host
//
// When somebody asks: read_columns after a frame; between frames cast_rays, or mark_looks and count_looks;
// at any time begin_spread, and spread_round again and again.
//
// Before a frame that is to be aligned: read_tiles, find_samples, count_chosen, choose, and match_step again and again;
// once its pose is known place_samples, lead_cells, add_samples, sweep_cells, export_cells.
//
// No launch waits for the host: counts stay on the card, and blocks of threads stride over what there is.
#pragma once

#include "mapper/cuda/kernels/align_surfaces.hpp"
#include "mapper/cuda/kernels/cast_rays.hpp"
#include "mapper/cuda/kernels/classes.hpp"
#include "mapper/cuda/kernels/columns.hpp"
#include "mapper/cuda/kernels/parcels.hpp"
#include "mapper/cuda/kernels/spread_grid.hpp"
#include "mapper/cuda/kernels/update_blocks.hpp"

namespace g3d::mapper::cuda {

/// 0 parcels: pools are tidied up instead, so that what earlier ones gave back can be taken by later ones.
inline G3D_GPU void import_blocks(const Block& block, const Memory& m, const Parcels& in, std::uint32_t count) {
  for (int task = block.index; task < kTidyTasks && count == 0; task += block.count) {
    tidy_share<kParcelThreads>(block, m, task);
  }
  for (std::uint32_t i = static_cast<std::uint32_t>(block.index); i < count;
       i += static_cast<std::uint32_t>(block.count)) {
    receive_block(block, m, in, i);
  }
}

inline G3D_GPU void read_image(const Block& block, const Memory& m, const FrameParams& f) {
  const int reads = tiles(f.width_px, kTile_px) * tiles(f.height_px, kTile_px);
  const int all = kTidyTasks + 2 * reads;
  for (int task = block.index; task < all; task += block.count) {
    if (task < kTidyTasks) {
      tidy_share<kPixelThreads>(block, m, task);
    } else if (task < kTidyTasks + reads) {
      read_tile(block, m, f, task - kTidyTasks);
    } else {
      mark_hit_blocks(block, m, f, task - kTidyTasks - reads);
    }
  }
}

inline G3D_GPU void walk_image(const Block& block, const Memory& m, const FrameParams& f) {
  const int all = tiles(f.width_px, kRayTileColumns) * tiles(f.height_px, kRayTileRows);
  for (int task = block.index; task < all; task += block.count) walk_tile(block, m, f, task);
}

inline G3D_GPU void find_work(const Block& block, const Memory& m, const FrameParams& f) {
  G3D_GPU_SHARED TopLevels top;
  // Where there is little to find, warps of different blocks of threads find it.
  const int together = least(tiles(find_tasks(f), block.count), kWarpsTogether);
  const int finds = tiles(find_tasks(f), together);
  if (f.free_by == FreeBy::projection && block.index < finds) make_top(block, m, f, top);
  const int scatters = tiles(f.width_px, kTileColumns) * tiles(f.height_px, kTileRows);
  int all = finds + scatters;
  for (int level = 0; level < f.image_levels; ++level) all += window_tasks(f, level);
  for (int task = block.index; task < all; task += block.count) {
    int rest = task;
    if (rest < finds) {
      find_blocks(block, m, f, top, rest, together);
      continue;
    }
    rest -= finds;
    if (rest < scatters) {
      scatter_hits(block, m, f, rest);
      continue;
    }
    rest -= scatters;
    int level = 0;
    for (; rest >= window_tasks(f, level); ++level) rest -= window_tasks(f, level);
    if (level == kTopLevel) {
      fill_top(block, m, f, rest);
    } else {
      fill_windows(block, m, f, level, rest);
    }
  }
}

/// One warp for each block of the map where there are many, four where there are few.
template <int kWarps>
inline G3D_GPU void update_map(const Block& block, const Memory& m, const FrameParams& f) {
  G3D_GPU_SHARED UpdateState states[kUpdateThreads / 32 / kWarps];
  const std::uint32_t count = m.input->counters.items;
  G3D_GPU_SHARED ChangedShares changed;
  ChangedSlots slots;
  block.teams<kWarps>([&](const Team<kWarps>& team) {
    update_share<kWarps>(team, m, f, states[team.in_block], count, changed, slots);
  });
  note_changed<kWarps>(block, m, changed, slots);
}

/// Counters, and classes of the changed blocks if there is room for all.
inline G3D_GPU void export_classes(const Block& block, const Memory& m, const FrameParams& f, const Classes& out,
                                   FrameCounters* counters, std::uint32_t room) {
  if (block.index == 0) send_counters(block, m, f, counters);
  const std::uint32_t count = m.input->counters.changed;
  if (count > room) return;
  block.teams<1>([&](const Team<1>& warp) {
    for (std::uint32_t i = static_cast<std::uint32_t>(warp.index); i < count;
         i += static_cast<std::uint32_t>(warp.count)) {
      send_classes(warp, m, out, i);
    }
  });
}

/// Changed blocks from number `first` on, as many as there is room for parcels.
inline G3D_GPU void export_blocks(const Block& block, const Memory& m, const Parcels& out, std::uint32_t first,
                                  std::uint32_t room) {
  const std::uint32_t end = least(m.input->counters.changed, first + room);
  for (std::uint32_t i = first + static_cast<std::uint32_t>(block.index); i < end;
       i += static_cast<std::uint32_t>(block.count)) {
    send_block(block, m, out, m.changed[i], i - first);
  }
}

}  // namespace g3d::mapper::cuda
