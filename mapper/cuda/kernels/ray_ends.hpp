// SPDX-License-Identifier: Apache-2.0
// Where rays end (cpu::RayEnds says by which rule). Bounds of missing readings along rows and columns are found side by
// side from the depth image; a later launch joins them (reduce.hpp).
#pragma once

#include "mapper/cuda/kernels/common.hpp"

namespace g3d::mapper::cuda {

inline constexpr std::uint32_t kUnbounded = 0xFFFF;  ///< no reading bounds the run on that side

struct RowScan {
  std::uint8_t readings[kPixelThreads];  ///< bit k of byte t: the thread's pixel k has a reading
  std::uint32_t counts[4];
};

/// Reading nearest to the left of a thread's eight pixels, kUnbounded if there is none; and to their right.
inline G3D_GPU std::uint32_t left_of(const std::uint8_t* readings, const std::uint16_t* depth, int byte) {
  std::uint32_t bits = 0;
  while (bits == 0 && byte > 0) bits = readings[--byte];
  return bits == 0 ? kUnbounded : depth[8 * byte + 31 - __builtin_clz(bits)];
}
inline G3D_GPU std::uint32_t right_of(const std::uint8_t* readings, const std::uint16_t* depth, int byte, int bytes) {
  std::uint32_t bits = 0;
  while (bits == 0 && byte + 1 < bytes) bits = readings[++byte];
  return bits == 0 ? kUnbounded : depth[8 * byte + __builtin_ctz(bits)];
}

/// Rows that one block of threads scans together, eight pixels to a thread.
[[nodiscard]] constexpr int rows_per_scan(int width_px) { return kPixelThreads / tiles(width_px, 8); }

/// Some rows: ends of their readings, row bounds of the pixels without one, counts.
inline G3D_GPU void scan_rows(const Block& block, const Memory& m, const FrameParams& f, int task) {
  G3D_GPU_SHARED RowScan scan;
  const int width = f.width_px;
  const int bytes = tiles(width, 8);
  const int rows = rows_per_scan(width);
  const auto row_of = [&](int t) { return t / bytes < rows ? task * rows + t / bytes : f.height_px; };
  block.each([&](int t) {
    if (t < 4) scan.counts[t] = 0;
    const int v = row_of(t);
    if (v >= f.height_px) return;
    const int first = 8 * (t % bytes);
    const std::uint16_t* depth = m.depth + v * width + first;
    std::uint16_t* ends = m.ends[0] + (v + kPadding) * f.shapes[0].stride + kPadding + first;
    std::uint32_t bits = 0;
    for (int k = 0; k < 8 && first + k < width; ++k) {
      const int d = depth[k];
      bits |= d != 0 ? 1U << k : 0U;
      ends[k] = static_cast<std::uint16_t>(d >= f.near_raw ? least(d, f.far_raw) : 0);
    }
    scan.readings[t] = static_cast<std::uint8_t>(bits);
  });
  block.each([&](int t) {
    const int v = row_of(t);
    if (v >= f.height_px) return;
    const int first = 8 * (t % bytes);
    const std::uint16_t* depth = m.depth + v * width;
    const std::uint8_t* readings = scan.readings + t / bytes * bytes;
    std::uint32_t counts[4] = {};
    std::uint32_t readings_here[8];
#pragma GCC unroll 8
    for (int k = 0; k < 8; ++k) {
      const int d = first + k < width ? depth[first + k] : 0;
      readings_here[k] = static_cast<std::uint32_t>(d);
      counts[0] += d != 0 && d >= f.near_raw && d <= f.far_raw ? 1 : 0;
      counts[1] += d != 0 && d < f.near_raw ? 1 : 0;
      counts[2] += d != 0 && d >= f.near_raw && d > f.far_raw ? 1 : 0;
      counts[3] += d == 0 && first + k < width ? 1 : 0;
    }
    if (counts[3] != 0) {
      std::uint16_t* ends = m.ends[0] + (v + kPadding) * f.shapes[0].stride + kPadding + first;
      std::uint32_t left[8];
      std::uint32_t bound = left_of(readings, depth, t % bytes);
#pragma GCC unroll 8
      for (int k = 0; k < 8; ++k) {
        left[k] = bound;
        bound = readings_here[k] != 0 ? readings_here[k] : bound;
      }
      bound = right_of(readings, depth, t % bytes, bytes);
#pragma GCC unroll 8
      for (int k = 7; k >= 0; --k) {
        if (readings_here[k] == 0 && first + k < width) ends[k] = static_cast<std::uint16_t>(least(left[k], bound));
        bound = readings_here[k] != 0 ? readings_here[k] : bound;
      }
    }
    for (int c = 0; c < 4; ++c) {
      if (counts[c] != 0) atomic_add(&scan.counts[c], counts[c]);
    }
  });
  block.each([&](int t) {
    FrameCounters& c = m.input->counters;
    std::uint32_t* const totals[4] = {&c.valid, &c.too_near, &c.far, &c.invalid};
    if (t < 4 && scan.counts[t] != 0) atomic_add(totals[t], scan.counts[t]);
  });
}

inline constexpr int kStripColumns = 8;
inline constexpr int kStripSegments = kPixelThreads / kStripColumns;
inline constexpr int kBatchRows = 8;  ///< read together: one wait instead of eight

struct ColumnScan {
  std::uint16_t first[kStripSegments][kStripColumns];  ///< reading of the segment; 0: it has none
  std::uint16_t last[kStripSegments][kStripColumns];
};

/// visit(v, reading) for rows begin..end of a column, downwards or upwards.
template <bool kDown, typename Visit>
inline G3D_GPU void for_column(const Memory& m, const FrameParams& f, int u, int begin, int end, Visit&& visit) {
  for (int done = 0; done < end - begin; done += kBatchRows) {
    std::uint32_t batch[kBatchRows];
#pragma GCC unroll 8
    for (int i = 0; i < kBatchRows; ++i) {
      const int step = least(done + i, end - begin - 1);
      batch[i] = m.depth[(kDown ? begin + step : end - 1 - step) * f.width_px + u];
    }
#pragma GCC unroll 8
    for (int i = 0; i < kBatchRows; ++i) {
      if (done + i < end - begin) visit(kDown ? begin + done + i : end - 1 - done - i, batch[i]);
    }
  }
}

/// Some columns, cut into segments: column bounds of their pixels without a reading.
inline G3D_GPU void scan_columns(const Block& block, const Memory& m, const FrameParams& f, int strip) {
  G3D_GPU_SHARED ColumnScan scan;
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
      for_column<true>(m, f, u, s * rows, least(f.height_px, (s + 1) * rows), [&](int, std::uint32_t d) {
        first = first == 0 ? d : first;
        last = d != 0 ? d : last;
        missing += d == 0 ? 1 : 0;
      });
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
    for_column<true>(m, f, u, begin, end, [&](int v, std::uint32_t d) {
      if (d == 0) m.column_bound[v * f.width_px + u] = static_cast<std::uint16_t>(bound);
      bound = d != 0 ? d : bound;
    });
    bound = kUnbounded;
    for (int q = s + 1; q < kStripSegments && bound == kUnbounded; ++q) {
      if (scan.first[q][c] != 0) bound = scan.first[q][c];
    }
    for_column<false>(m, f, u, begin, end, [&](int v, std::uint32_t d) {
      std::uint16_t& stored = m.column_bound[v * f.width_px + u];
      if (d == 0 && bound < stored) stored = static_cast<std::uint16_t>(bound);
      bound = d != 0 ? d : bound;
    });
  });
}

}  // namespace g3d::mapper::cuda
