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

inline G3D_GPU void store_cell(const FrameParams& f, const Memory& m, int level, int x, int y, std::uint32_t low,
                               std::uint32_t high) {
  const ImageShape& shape = f.shapes[level];
  if (x >= shape.width || y >= shape.height) return;
  if (level < f.image_levels) {
    m.ends[level][(y + kPadding) * shape.stride + x + kPadding] = static_cast<std::uint16_t>(high);
  }
  if (level >= kBaseLevel) m.pyramid[level - kBaseLevel][y * shape.width + x] = low | high << 16;
}

struct ReduceTile {
  std::uint16_t low[kReduceSide][kReduceSide];
  std::uint16_t high[kReduceSide][kReduceSide];
};

/// 64 x 64 pixels: joins the bounds, then halves six times.
inline G3D_GPU void reduce_tile(const Block& block, const Memory& m, int tile) {
  G3D_GPU_SHARED ReduceTile s;
  const FrameParams& f = m.input->params;
  const int across = tiles(f.width_px, kReduceTile_px);
  const int tile_u = tile % across * kReduceTile_px;
  const int tile_v = tile / across * kReduceTile_px;
  block.each([&](int t) {
    const int tx = t % kReduceSide;
    const int ty = t / kReduceSide;
    const int u0 = tile_u + 4 * tx;
    const int v0 = tile_v + 4 * ty;
    // Beyond the image lies padding: zeros. A lower minimum is always safe, and it is the CPU twin's.
    std::uint32_t low = kUnbounded;
    std::uint32_t quarter[2][2] = {};
    for (int dy = 0; dy < 4; ++dy) {
      for (int dx = 0; dx < 4; ++dx) {
        const int u = u0 + dx;
        const int v = v0 + dy;
        std::uint32_t end = 0;
        if (u < f.width_px && v < f.height_px) {
          std::uint16_t& stored = m.ends[0][(v + kPadding) * f.shapes[0].stride + u + kPadding];
          end = stored;
          if (m.depth[v * f.width_px + u] == 0) {
            end = weak_end(f, m, v * f.width_px + u, end);
            stored = static_cast<std::uint16_t>(end);
          }
        }
        low = least(low, end);
        quarter[dy / 2][dx / 2] = most(quarter[dy / 2][dx / 2], end);
      }
    }
    for (int q = 0; q < 4; ++q) store_cell(f, m, 1, u0 / 2 + q % 2, v0 / 2 + q / 2, 0, quarter[q / 2][q % 2]);
    const std::uint32_t high = most(most(quarter[0][0], quarter[0][1]), most(quarter[1][0], quarter[1][1]));
    store_cell(f, m, 2, u0 / 4, v0 / 4, low, high);
    // A cell wholly outside of the image must not lower those above it.
    const bool exists = u0 < f.width_px && v0 < f.height_px;
    s.low[ty][tx] = static_cast<std::uint16_t>(exists ? low : 0xFFFFU);
    s.high[ty][tx] = static_cast<std::uint16_t>(exists ? high : 0U);
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
      std::uint16_t& low = s.low[sy][sx];
      std::uint16_t& high = s.high[sy][sx];
      low = least(least(low, s.low[sy][sx + gap]), least(s.low[sy + gap][sx], s.low[sy + gap][sx + gap]));
      high = most(most(high, s.high[sy][sx + gap]), most(s.high[sy + gap][sx], s.high[sy + gap][sx + gap]));
      store_cell(f, m, level, (tile_u >> level) + x, (tile_v >> level) + y, low, high);
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
inline G3D_GPU void fill_windows(const Block& block, const Memory& m, int level, int task) {
  const FrameParams& f = m.input->params;
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

/// Farthest end within a window of 1..7 cells that begins at a padded cell.
inline G3D_GPU std::uint32_t window_maximum(const FrameParams& f, const Memory& m, int level, int cells, int x, int y) {
  const int stride = f.shapes[level].stride;
  const int first = y * stride + x;
  if (cells == 1) return m.ends[level][first];
  const std::uint16_t* image = cells >= 4 ? m.four[level] : m.two;
  const int shift = cells >= 4 ? cells - 4 : cells - 2;
  if (shift == 0) return image[first];
  return most(most(image[first], image[first + shift]),
              most(image[first + shift * stride], image[first + shift * stride + shift]));
}

}  // namespace g3d::mapper::cuda
