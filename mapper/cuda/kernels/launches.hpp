// SPDX-License-Identifier: Apache-2.0
// The launches of one frame, in order. Each does several things that do not depend on one another, dealt out to its
// blocks of threads, since at these sizes the gaps between launches cost as much as the work:
//
//   import_blocks    what the host changed since the last frame (only if it did)
//   scan_image       row bounds | column bounds | blocks with hits are numbered | what was given back is collected
//   reduce_image     ray ends, their minima and maxima | pixels to hit records
//   walk_image       rays mark the box (dda and bresenham alone)
//   find_work        window images | blocks that rays reach or have marked | blocks with hits
//   update_map       levels and colours
//   export_blocks    changed blocks and counters to the host
//
// No launch waits for the host: counts stay on the card, and blocks of threads stride over what there is.
#pragma once

#include "mapper/cuda/kernels/parcels.hpp"
#include "mapper/cuda/kernels/update_blocks.hpp"

namespace g3d::mapper::cuda {

inline constexpr int kHitWorkers = 32;

inline G3D_GPU void import_blocks(const Block& block, const Memory& m, const Parcels& in, std::uint32_t count) {
  for (std::uint32_t i = static_cast<std::uint32_t>(block.index); i < count;
       i += static_cast<std::uint32_t>(block.count)) {
    receive_block(block, m, in, i);
  }
}

inline G3D_GPU void scan_image(const Block& block, const Memory& m, const FrameParams& f) {
  const int marks = tiles(f.width_px, kTileColumns) * tiles(f.height_px, kTileRows);
  const int strips = tiles(f.width_px, kStripColumns);
  const int rows = tiles(f.height_px, rows_per_scan(f.width_px));
  const int all = strips + marks + rows + 1;
  for (int task = block.index; task < all; task += block.count) {
    if (task == 0) {
      MapState& s = *m.state;
      collect_returned(block, s.blocks, m.free_blocks, m.returned_blocks, kPixelThreads);
      collect_returned(block, s.planes, m.free_planes, m.returned_planes, kPixelThreads);
      collect_returned(block, s.bricks, m.free_bricks, m.returned_bricks, kPixelThreads);
    } else if (task <= strips) {
      scan_columns(block, m, f, task - 1);
    } else if (task <= strips + rows) {
      scan_rows(block, m, f, task - strips - 1);
    } else {
      mark_hit_blocks(block, m, f, task - strips - rows - 1);
    }
  }
}

inline G3D_GPU void reduce_image(const Block& block, const Memory& m, const FrameParams& f) {
  const int reduces = tiles(f.width_px, kReduceTile_px) * tiles(f.height_px, kReduceTile_px);
  const int all = reduces + tiles(f.width_px, kTileColumns) * tiles(f.height_px, kTileRows);
  for (int task = block.index; task < all; task += block.count) {
    if (task < reduces) {
      reduce_tile(block, m, f, task);
    } else {
      scatter_hits(block, m, f, task - reduces);
    }
  }
}

inline G3D_GPU void walk_image(const Block& block, const Memory& m, const FrameParams& f) {
  const int all = tiles(f.width_px, kRayTileColumns) * tiles(f.height_px, kRayTileRows);
  for (int task = block.index; task < all; task += block.count) walk_tile(block, m, f, task);
}

inline G3D_GPU void find_work(const Block& block, const Memory& m, const FrameParams& f) {
  int finds = 0;
  if (f.free_by == FreeBy::projection) finds = tiles(f.supers[0] * f.supers[1] * f.supers[2], kSupersPerTask);
  if (walks_rays(f.free_by)) finds = tiles(f.blocks[0] * f.blocks[1] * f.blocks[2], kPixelThreads);
  int all = kHitWorkers + finds;
  for (int level = 0; level < f.image_levels; ++level) all += window_tasks(f, level);
  for (int task = block.index; task < all; task += block.count) {
    int rest = task;
    if (rest < kHitWorkers) {
      find_hit_blocks(block, m, f, rest, kHitWorkers);
      continue;
    }
    rest -= kHitWorkers;
    if (rest < finds) {
      if (f.free_by == FreeBy::projection) {
        find_visible(block, m, f, rest);
      } else {
        find_marked(block, m, f, rest);
      }
      continue;
    }
    rest -= finds;
    int level = 0;
    for (; rest >= window_tasks(f, level); ++level) rest -= window_tasks(f, level);
    fill_windows(block, m, f, level, rest);
  }
}

inline G3D_GPU void update_map(const Block& block, const Memory& m, const FrameParams& f) {
  const std::uint32_t count = m.input->counters.items;
  for (std::uint32_t i = static_cast<std::uint32_t>(block.index); i < count;
       i += static_cast<std::uint32_t>(block.count)) {
    update_block(block, m, f, i);
  }
}

/// Changed blocks from number `first` on, as many as there is room for parcels.
inline G3D_GPU void export_blocks(const Block& block, const Memory& m, const Parcels& out, FrameCounters* counters,
                                  std::uint32_t first, std::uint32_t room) {
  if (block.index == 0) {
    block.each([&](int t) {
      if (t != 0) return;
      *counters = m.input->counters;
      counters->refused_imports = m.state->refused_imports;
    });
  }
  const std::uint32_t end = least(m.input->counters.changed, first + room);
  for (std::uint32_t i = first + static_cast<std::uint32_t>(block.index); i < end;
       i += static_cast<std::uint32_t>(block.count)) {
    send_block(block, m, out, m.changed[i], i - first);
  }
}

}  // namespace g3d::mapper::cuda
