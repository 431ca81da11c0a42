// SPDX-License-Identifier: Apache-2.0
// Questions to the map in the card, between frames: rays in bulk, a thread for each, and what looks from many poses
// would newly show. Nothing of the map changes.
#pragma once

#include "mapper/cuda/kernels/block_table.hpp"
#include "mapper/look.hpp"

namespace g3d::mapper::cuda {

struct CardBlocks {
  const Memory& m;
  [[nodiscard]] G3D_GPU BlockLevels find(BlockKey key) const {
    const std::uint32_t slot = find_block(m, key);
    if (slot == kNone) return {nullptr, kUnknownLevel};
    const GpuBlock& block = m.blocks[slot];
    if (block.plane == kNone) return {nullptr, block.uniform_level};
    return {m.planes + static_cast<std::size_t>(block.plane) * kVoxels, 0};
  }
};

inline G3D_GPU void cast_rays(const Block& block, const Memory& m, float resolution_m, std::uint32_t count) {
  block.lanes([&](int t) {
    const auto stride = static_cast<std::uint32_t>(block.count * kParcelThreads);
    for (std::uint32_t i = static_cast<std::uint32_t>(block.index * kParcelThreads + t); i < count; i += stride) {
      m.ray_hits[i] = cast_bulk_ray(m.rays[i], resolution_m, CardBlocks{m});
    }
  });
}

inline constexpr int kLookTile = 16;  ///< rays along a side: those of a block of threads stay close to one another

/// Rays of tile `task`, counted over the tiles of all looks.
inline G3D_GPU void look_tile(const Block& block, const Memory& m, const LookModel& model, int task) {
  const int columns = tiles(model.width_px, model.stride_px);
  const int rows = tiles(model.height_px, model.stride_px);
  const int across = tiles(columns, kLookTile);
  const int per_look = across * tiles(rows, kLookTile);
  const int tile = task % per_look;
  Look& look = m.looks[task / per_look];
  std::uint32_t* seen = m.seen + static_cast<std::size_t>(task / per_look) * m.seen_stride;
  PerThread<std::uint32_t, kPixelThreads> ends[2];
  block.lanes([&](int t) {
    const int column = tile % across * kLookTile + t % kLookTile;
    const int row = tile / across * kLookTile + t / kLookTile;
    LookEnd end = LookEnd::open;
    if (column < columns && row < rows) {
      end = look_along(model, look, m.column_slope[column * model.stride_px], m.row_slope[row * model.stride_px],
                       CardBlocks{m}, [&](std::uint64_t bit) {
                         std::uint32_t* word = seen + bit / 32;
                         const std::uint32_t mask = 1U << (bit % 32);
                         if ((*word & mask) == 0) atomic_or(word, mask);  // most were seen by a neighbour
                       });
    }
    ends[0][t] = end == LookEnd::blocked ? 1 : 0;
    ends[1][t] = end == LookEnd::near ? 1 : 0;
  });
  block.lanes([&](int t) {
    const std::uint32_t blocked = ends[0].ballot(t);
    const std::uint32_t near = ends[1].ballot(t);
    if (t % 32 != 0) return;
    if (blocked != 0) atomic_add(&look.gain.blocked_rays, static_cast<std::uint32_t>(__builtin_popcount(blocked)));
    if (near != 0) atomic_add(&look.gain.near_rays, static_cast<std::uint32_t>(__builtin_popcount(near)));
  });
}

inline G3D_GPU void mark_looks(const Block& block, const Memory& m, const LookModel& model, std::uint32_t count) {
  const int per_look = tiles(tiles(model.width_px, model.stride_px), kLookTile) *
                       tiles(tiles(model.height_px, model.stride_px), kLookTile);
  const int all = static_cast<int>(count) * per_look;
  for (int task = block.index; task < all; task += block.count) look_tile(block, m, model, task);
}

/// Counts the bits of every look's box and takes them away.
inline G3D_GPU void count_looks(const Block& block, const Memory& m, std::uint32_t count) {
  PerThread<std::uint32_t, kPixelThreads> sum;
  PerThread<std::uint32_t, kPixelThreads> next;
  for (std::uint32_t i = 0; i < count; ++i) {
    Look& look = m.looks[i];
    block.lanes([&](int t) {
      const std::uint32_t quads =
          static_cast<std::uint32_t>(look.blocks[0] * look.blocks[1] * look.blocks[2]) * kSeenWords / 4;
      AnyQuad* seen = reinterpret_cast<AnyQuad*>(m.seen + static_cast<std::size_t>(i) * m.seen_stride);
      std::uint32_t bits = 0;
      for (std::uint32_t q = static_cast<std::uint32_t>(block.index * kPixelThreads + t); q < quads;
           q += static_cast<std::uint32_t>(block.count * kPixelThreads)) {
        const AnyQuad words = seen[q];
        std::uint32_t here = 0;
        for (const std::uint32_t word : words.words) here += static_cast<std::uint32_t>(__builtin_popcount(word));
        if (here != 0) seen[q] = {};
        bits += here;
      }
      sum[t] = bits;
    });
#pragma GCC unroll 1
    for (int bits = 1; bits < 32; bits *= 2) {
      block.lanes([&](int t) { next[t] = sum[t] + sum.peer(t, bits); });
      block.lanes([&](int t) { sum[t] = next[t]; });
    }
    block.lanes([&](int t) {
      if (t % 32 == 0 && sum[t] != 0) atomic_add(&look.gain.unknown_voxels, sum[t]);
    });
  }
}

}  // namespace g3d::mapper::cuda
