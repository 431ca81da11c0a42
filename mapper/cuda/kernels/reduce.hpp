// SPDX-License-Identifier: Apache-2.0
// From ray ends to what blocks and voxels look up: maxima of 2x2 cells level by level, minima beside them (the depth
// pyramid), and maxima over windows. A window of 4..7 cells is the maximum of four windows of 4 that overlap, so two
// images per level replace the CPU twin's seven: looking four times costs a card less than making them.
#pragma once

#include "mapper/cuda/kernels/ray_ends.hpp"

namespace g3d::mapper::cuda {

inline constexpr int kReduceTile_px = 64;
inline constexpr int kReduceSide = 16;  ///< threads along each axis, 4x4 pixels each

/// The final end of a pixel without a reading: a weak one.
inline G3D_GPU std::uint32_t weak_end(const FrameParams& f, const Memory& m, int pixel, std::uint32_t row_bound) {
  const std::uint32_t nearest = least(row_bound, static_cast<std::uint32_t>(m.column_bound[pixel]));
  const bool carves =
      f.carve_invalid != 0 && nearest != kUnbounded && nearest >= static_cast<std::uint32_t>(f.near_raw);
  return carves ? least(static_cast<std::uint32_t>(m.mask[pixel]), nearest) : 0U;
}

/// What is known of the ray ends in one cell.
struct CellEnds {
  std::uint16_t low;
  std::uint16_t high;
  std::uint16_t strong;  ///< farthest of measured rays
};
inline G3D_GPU void join(CellEnds& cell, const CellEnds& other) {
  cell = {least(cell.low, other.low), most(cell.high, other.high), most(cell.strong, other.strong)};
}

inline G3D_GPU void store_cell(const FrameParams& f, const Memory& m, int level, int x, int y, const CellEnds& ends) {
  const ImageShape& shape = f.shapes[level];
  if (x >= shape.width || y >= shape.height) return;
  if (level < f.image_levels) {
    const int cell = (y + kPadding) * shape.stride + x + kPadding;
    m.ends[level][cell] = ends.high;
    m.strong[level][cell] = ends.strong;
  }
  if (level >= kBaseLevel) {
    m.pyramid[level - kBaseLevel][y * shape.width + x] =
        static_cast<std::uint32_t>(ends.low) | static_cast<std::uint32_t>(ends.high) << 16;
  }
}

/// 64 x 64 pixels: joins the bounds, then halves six times.
inline G3D_GPU void reduce_tile(const Block& block, const Memory& m, const FrameParams& f, int tile) {
  G3D_GPU_SHARED CellEnds cells[kReduceSide][kReduceSide];
  const int across = tiles(f.width_px, kReduceTile_px);
  const int tile_u = tile % across * kReduceTile_px;
  const int tile_v = tile / across * kReduceTile_px;
  block.each([&](int t) {
    const int tx = t % kReduceSide;
    const int ty = t / kReduceSide;
    const int u0 = tile_u + 4 * tx;
    const int v0 = tile_v + 4 * ty;
    constexpr CellEnds kNothing{0xFFFF, 0, 0};
    CellEnds all = kNothing;
#pragma GCC unroll 4
    for (int q = 0; q < 4; ++q) {
      CellEnds quarter = kNothing;
#pragma GCC unroll 4
      for (int i = 0; i < 4; ++i) {
        const int u = u0 + q % 2 * 2 + i % 2;
        const int v = v0 + q / 2 * 2 + i / 2;
        // Beyond the image lies padding: zeros. A lower minimum is always safe, and it is the CPU twin's.
        CellEnds pixel{0, 0, 0};
        if (u < f.width_px && v < f.height_px) {
          std::uint16_t& stored = m.ends[0][(v + kPadding) * f.shapes[0].stride + u + kPadding];
          std::uint32_t end = stored;
          const bool measured = m.depth[v * f.width_px + u] != 0;
          if (!measured) {
            end = weak_end(f, m, v * f.width_px + u, end);
            stored = static_cast<std::uint16_t>(end);
          }
          const std::uint16_t final_end = static_cast<std::uint16_t>(end);
          pixel = {final_end, final_end, measured ? final_end : std::uint16_t{0}};
        }
        join(quarter, pixel);
      }
      store_cell(f, m, 1, u0 / 2 + q % 2, v0 / 2 + q / 2, quarter);
      join(all, quarter);
    }
    store_cell(f, m, 2, u0 / 4, v0 / 4, all);
    // A cell wholly outside of the image must not lower those above it.
    cells[ty][tx] = u0 < f.width_px && v0 < f.height_px ? all : kNothing;
  });
  for (int level = 3; level < kImageLevels; ++level) {
    const int side = kReduceTile_px >> level;
    const int gap = 1 << (level - 3);  // between the cells of the level below
    block.each([&](int t) {
      if (t >= side * side) return;
      const int x = t % side;
      const int y = t / side;
      const int sx = 2 * gap * x;
      const int sy = 2 * gap * y;
      CellEnds& cell = cells[sy][sx];
      join(cell, cells[sy][sx + gap]);
      join(cell, cells[sy + gap][sx]);
      join(cell, cells[sy + gap][sx + gap]);
      store_cell(f, m, level, (tile_u >> level) + x, (tile_v >> level) + y, cell);
    });
  }
}

inline constexpr int kWindowCellsPerThread = 4;
inline constexpr int kWindowCells = kPixelThreads * kWindowCellsPerThread;

/// Tasks that level needs, 0 if nobody asks for its windows.
inline G3D_GPU int window_tasks(const FrameParams& f, int level) {
  if ((f.wanted_images >> level & 1U) == 0) return 0;
  return tiles(f.shapes[level].stride * f.shapes[level].rows, kWindowCells);
}

/// A thousand cells of one level's window images.
inline G3D_GPU void fill_windows(const Block& block, const Memory& m, const FrameParams& f, int level, int task) {
  const ImageShape& shape = f.shapes[level];
  const std::uint16_t* ends = m.ends[level];
  block.each([&](int t) {
    for (int i = 0; i < kWindowCellsPerThread; ++i) {
      const int cell = task * kWindowCells + i * kPixelThreads + t;
      const int x = cell % shape.stride;
      const int y = cell / shape.stride;
      if (x > shape.stride - 4 || y > shape.rows - 4) continue;
      std::uint16_t pairs[4];
      std::uint16_t fours[4];
      for (int dy = 0; dy < 4; ++dy) {
        const std::uint16_t* row = ends + cell + dy * shape.stride;
        pairs[dy] = most(row[0], row[1]);
        fours[dy] = most(pairs[dy], most(row[2], row[3]));
      }
      if (level == 0) m.two[cell] = most(pairs[0], pairs[1]);
      m.four[level][cell] = most(most(fours[0], fours[1]), most(fours[2], fours[3]));
    }
  });
}

}  // namespace g3d::mapper::cuda
