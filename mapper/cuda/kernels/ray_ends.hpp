// SPDX-License-Identifier: Apache-2.0
// Where rays end (cpu::RayEnds says by which rule). Bounds of missing readings along rows and columns are found side by
// side from the depth image; a later launch joins them (reduce.hpp).
#pragma once

#include "mapper/cuda/kernels/common.hpp"

namespace g3d::mapper::cuda {

inline constexpr std::uint32_t kUnbounded = 0xFFFF;  ///< no reading bounds the run on that side

struct RowScan {
  std::uint8_t readings[kPixelThreads];  ///< bit k of byte t: pixel 8 t + k has a reading
  std::uint32_t counts[4];
};

/// Reading nearest to the left of pixel 8 t + k, kUnbounded if there is none.
inline G3D_GPU std::uint32_t left_of(const RowScan& scan, const std::uint16_t* depth, int t, int k) {
  int byte = t;
  std::uint32_t bits = scan.readings[t] & ((1U << k) - 1U);
  while (bits == 0 && byte > 0) bits = scan.readings[--byte];
  return bits == 0 ? kUnbounded : depth[8 * byte + 31 - __builtin_clz(bits)];
}
inline G3D_GPU std::uint32_t right_of(const RowScan& scan, const std::uint16_t* depth, int t, int k, int bytes) {
  int byte = t;
  std::uint32_t bits = scan.readings[t] & (0xFFU << (k + 1)) & 0xFFU;
  while (bits == 0 && byte + 1 < bytes) bits = scan.readings[++byte];
  return bits == 0 ? kUnbounded : depth[8 * byte + __builtin_ctz(bits)];
}

/// One row: ends of its readings, row bounds of the pixels without one, counts. Eight pixels to a thread.
inline G3D_GPU void scan_row(const Block& block, const Memory& m, int v) {
  G3D_GPU_SHARED RowScan scan;
  const FrameParams& f = m.input->params;
  const int width = f.width_px;
  const std::uint16_t* depth = m.depth + v * width;
  std::uint16_t* ends = m.ends[0] + (v + kPadding) * f.shapes[0].stride + kPadding;
  block.each([&](int t) {
    if (t < 4) scan.counts[t] = 0;
    std::uint32_t bits = 0;
    for (int k = 0; k < 8 && 8 * t + k < width; ++k) {
      const int d = depth[8 * t + k];
      bits |= d != 0 ? 1U << k : 0U;
      if (d != 0) ends[8 * t + k] = static_cast<std::uint16_t>(d >= f.near_raw ? least(d, f.far_raw) : 0);
    }
    scan.readings[t] = static_cast<std::uint8_t>(bits);
  });
  block.each([&](int t) {
    std::uint32_t valid = 0;
    std::uint32_t too_near = 0;
    std::uint32_t far = 0;
    std::uint32_t invalid = 0;
    for (int k = 0; k < 8 && 8 * t + k < width; ++k) {
      const int d = depth[8 * t + k];
      if (d == 0) {
        ++invalid;
        ends[8 * t + k] =
            static_cast<std::uint16_t>(least(left_of(scan, depth, t, k), right_of(scan, depth, t, k, tiles(width, 8))));
      } else if (d < f.near_raw) {
        ++too_near;
      } else if (d > f.far_raw) {
        ++far;
      } else {
        ++valid;
      }
    }
    if (valid != 0) atomic_add(&scan.counts[0], valid);
    if (too_near != 0) atomic_add(&scan.counts[1], too_near);
    if (far != 0) atomic_add(&scan.counts[2], far);
    if (invalid != 0) atomic_add(&scan.counts[3], invalid);
  });
  block.each([&](int t) {
    FrameCounters& c = m.input->counters;
    std::uint32_t* const totals[4] = {&c.valid, &c.too_near, &c.far, &c.invalid};
    if (t < 4 && scan.counts[t] != 0) atomic_add(totals[t], scan.counts[t]);
  });
}

inline constexpr int kStripColumns = 16;
inline constexpr int kStripSegments = kPixelThreads / kStripColumns;

struct ColumnScan {
  std::uint16_t first[kStripSegments][kStripColumns];  ///< reading of the segment; 0: it has none
  std::uint16_t last[kStripSegments][kStripColumns];
};

/// Sixteen columns, cut into sixteen segments: column bounds of their pixels without a reading.
inline G3D_GPU void scan_columns(const Block& block, const Memory& m, int strip) {
  G3D_GPU_SHARED ColumnScan scan;
  const FrameParams& f = m.input->params;
  const int rows = tiles(f.height_px, kStripSegments);
  PerThread<std::uint32_t, kPixelThreads> blind;
  block.each([&](int t) {
    const int c = t % kStripColumns;
    const int s = t / kStripColumns;
    const int u = strip * kStripColumns + c;
    std::uint32_t first = 0;
    std::uint32_t last = 0;
    std::uint32_t missing = 0;
    if (u < f.width_px) {
      for (int v = s * rows; v < least(f.height_px, (s + 1) * rows); ++v) {
        const std::uint32_t d = m.depth[v * f.width_px + u];
        first = first == 0 ? d : first;
        last = d != 0 ? d : last;
        missing += d == 0 ? 1 : 0;
      }
    }
    scan.first[s][c] = static_cast<std::uint16_t>(first);
    scan.last[s][c] = static_cast<std::uint16_t>(last);
    blind[t] = missing;
  });
  block.each([&](int t) {
    if (blind[t] == 0) return;
    const int c = t % kStripColumns;
    const int s = t / kStripColumns;
    const int u = strip * kStripColumns + c;
    const int begin = s * rows;
    const int end = least(f.height_px, (s + 1) * rows);
    std::uint32_t bound = kUnbounded;
    for (int q = s - 1; q >= 0 && bound == kUnbounded; --q) {
      if (scan.last[q][c] != 0) bound = scan.last[q][c];
    }
    for (int v = begin; v < end; ++v) {
      const std::uint32_t d = m.depth[v * f.width_px + u];
      if (d == 0) m.column_bound[v * f.width_px + u] = static_cast<std::uint16_t>(bound);
      bound = d != 0 ? d : bound;
    }
    bound = kUnbounded;
    for (int q = s + 1; q < kStripSegments && bound == kUnbounded; ++q) {
      if (scan.first[q][c] != 0) bound = scan.first[q][c];
    }
    for (int v = end - 1; v >= begin; --v) {
      const std::uint32_t d = m.depth[v * f.width_px + u];
      std::uint16_t& stored = m.column_bound[v * f.width_px + u];
      if (d == 0 && bound < stored) stored = static_cast<std::uint16_t>(bound);
      bound = d != 0 ? d : bound;
    }
  });
}

}  // namespace g3d::mapper::cuda
