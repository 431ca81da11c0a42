// SPDX-License-Identifier: Apache-2.0
// Where rays end (cpu::RayEnds says by which rule), tile by tile: 32 x 32 pixels to a block of threads, four neighbours
// to a thread. Missing readings are bounded by what the tile holds, which bit masks of its rows and columns tell at
// once; where a run goes on beyond the tile, one thread walks on along it. Kernels are kept short: a card executes most
// of this once per frame, and waits for code as it does for data.
#pragma once

#include "mapper/cuda/kernels/common.hpp"

namespace g3d::mapper::cuda {

inline constexpr std::uint32_t kUnbounded = 0xFFFF;  ///< no reading bounds the run on that side
inline constexpr int kTile_px = 32;
inline constexpr int kTileStride = kTile_px + 2;  ///< so that the rows of a column lie in 32 banks of shared memory
inline constexpr int kFewLooks = 4;               ///< together: one wait instead of many
inline constexpr int kManyLooks = 16;             ///< of each lane
inline constexpr int kRun_px = 4;                 ///< of a thread

/// What is known of the ray ends in one cell, as two words that threads of a warp can tell each other.
struct CellEnds {
  std::uint32_t ends;    ///< lowest | highest << 16
  std::uint32_t strong;  ///< farthest of measured rays
};

struct alignas(16) EndTile {
  std::uint16_t raw[kTile_px][kTileStride];  ///< readings; where there is none, in the end its bound
  std::uint32_t row_bits[kTile_px];          ///< bit x: has a reading
  std::uint32_t column_bits[kTile_px];
  std::uint16_t outside[4][kTile_px];    ///< first reading left of each row, right of it, above each column, below it
  CellEnds cells[8][8];                  ///< of 4 x 4 pixels
  std::uint8_t long_runs[4 * kTile_px];  ///< ends of lines that nothing bounds nearby
  std::uint32_t long_run_count;
  std::uint32_t kinds[kPixelThreads / 32];  ///< see kind_of()
};

/// Where a tile and a thread's run in it begin.
struct RunPlace {
  int first_u, first_v;  ///< of the tile
  int x, y;              ///< of the run in it
};
inline G3D_GPU RunPlace run_of(const FrameParams& f, int tile, int t) {
  const int across = tiles(f.width_px, kTile_px);
  return {tile % across * kTile_px, tile / across * kTile_px, t % 8 * kRun_px, t / 8};
}

/// Four neighbours of an image without padding from column u on, 0 beside it: two to a word.
inline G3D_GPU AnyPair read_four(const FrameParams& f, const std::uint16_t* image, int u, int v) {
  if (v >= f.height_px || u >= f.width_px) return {0, 0};
  const std::uint16_t* from = image + v * f.width_px + u;
  if (f.width_px % kRun_px == 0) return *reinterpret_cast<const AnyPair*>(from);
  std::uint32_t words[2] = {0, 0};
  for (int i = 0; i < kRun_px; ++i) {
    if (u + i < f.width_px) (i < 2 ? words[0] : words[1]) |= static_cast<std::uint32_t>(from[i]) << (16 * (i % 2));
  }
  return {words[0], words[1]};
}
[[nodiscard]] constexpr std::uint32_t half_of(const AnyPair& four, int i) {
  return (i < 2 ? four.low : four.high) >> (16 * (i % 2)) & 0xFFFFU;
}

/// Where a line of the tile goes on beyond one of its ends.
struct Outside {
  int first;  ///< pixel
  int left;   ///< pixels up to the image's border
  int step;   ///< from one to the next
};

/// Of end t / 32 (left, right, upper, lower) of row or column t % 32. Nothing is left where the run ends in the tile.
inline G3D_GPU Outside beyond(const FrameParams& f, const EndTile& s, const RunPlace& place, int t) {
  const int side = t / kTile_px;
  const int line = t % kTile_px;
  const bool is_row = side < 2;
  const bool goes_up = side % 2 != 0;  // to larger columns or rows
  const int last_x = least(kTile_px, f.width_px - place.first_u) - 1;
  const int last_y = least(kTile_px, f.height_px - place.first_v) - 1;
  const int end = goes_up ? (is_row ? last_x : last_y) : 0;
  const int x = is_row ? end : line;
  const int y = is_row ? line : end;
  if (x > last_x || y > last_y || s.raw[y][x] != 0) return {0, 0, 0};
  const int step = goes_up ? 1 : -1;
  const int u = place.first_u + x + (is_row ? step : 0);
  const int v = place.first_v + y + (is_row ? 0 : step);
  const int position = is_row ? u : v;
  return {v * f.width_px + u, goes_up ? (is_row ? f.width_px : f.height_px) - position : position + 1,
          is_row ? step : step * f.width_px};
}

/// Thread t of 128 looks a little beyond one end of one line. Most runs are short; others are left to whole warps.
inline G3D_GPU void look_outside(const FrameParams& f, const Memory& m, EndTile& s, const RunPlace& place, int t) {
  const Outside o = beyond(f, s, place, t);
  std::uint32_t found = 0;
  if (o.left > 0) {
    std::uint32_t batch[kFewLooks];
#pragma GCC unroll 4
    for (int i = 0; i < kFewLooks; ++i) batch[i] = m.depth[o.first + least(i, o.left - 1) * o.step];
#pragma GCC unroll 4
    for (int i = 0; i < kFewLooks; ++i) found = found == 0 ? batch[i] : found;
    if (found == 0 && o.left > kFewLooks) s.long_runs[atomic_add(&s.long_run_count, 1U)] = static_cast<std::uint8_t>(t);
  }
  s.outside[t / kTile_px][t % kTile_px] = static_cast<std::uint16_t>(found != 0 ? found : kUnbounded);
}

/// A warp looks far beyond: 512 pixels in one wait.
inline G3D_GPU void look_far(const Team<1>& warp, const FrameParams& f, const Memory& m, EndTile& s, int tile,
                             int run) {
  const int t = s.long_runs[run];
  const Outside o = beyond(f, s, run_of(f, tile, t), t);
  PerThread<std::uint32_t, 32> best[2];  // distance << 16 | reading
  for (int done = kFewLooks; done < o.left; done += 32 * kManyLooks) {
    warp.lanes([&](int lane) {
      std::uint32_t batch[kManyLooks];
#pragma GCC unroll 16
      for (int i = 0; i < kManyLooks; ++i) {
        batch[i] = m.depth[o.first + least(done + 32 * i + lane, o.left - 1) * o.step];
      }
      best[0][lane] = 0xFFFFFFFFU;
#pragma GCC unroll 16
      for (int i = kManyLooks - 1; i >= 0; --i) {
        const std::uint32_t distance = static_cast<std::uint32_t>(done + 32 * i + lane);
        if (batch[i] != 0) best[0][lane] = distance << 16 | batch[i];
      }
    });
#pragma GCC unroll 5
    for (int i = 0; i < 5; ++i) {
      warp.lanes([&](int lane) { best[(i + 1) % 2][lane] = least(best[i % 2][lane], best[i % 2].peer(lane, 1 << i)); });
    }
    if (best[1][0] == 0xFFFFFFFFU) continue;
    warp.lanes([&](int lane) {
      if (lane == 0) s.outside[t / kTile_px][t % kTile_px] = static_cast<std::uint16_t>(best[1][lane] & 0xFFFFU);
    });
    return;
  }
}

/// Nearest reading on one side of place `at` of a line of the tile: its place, -1 if the tile has none there.
[[nodiscard]] constexpr int before(std::uint32_t bits, int at) {
  const std::uint32_t lower = bits & ((1U << at) - 1);
  return lower == 0 ? -1 : 31 - __builtin_clz(lower);
}
[[nodiscard]] constexpr int behind(std::uint32_t bits, int at) {
  const std::uint32_t higher = bits >> at >> 1;
  return higher == 0 ? -1 : at + 1 + __builtin_ctz(higher);
}

/// Bounds of a thread's pixels without a reading, the nearest of four. They go where no other thread looks.
inline G3D_GPU void bound_run(const FrameParams& f, EndTile& s, const RunPlace& place) {
  const int y = place.y;
  const std::uint32_t in_row = s.row_bits[y];
  const int count = least(kRun_px, f.width_px - place.first_u - place.x);
  if (count <= 0 || place.first_v + y >= f.height_px) return;
  std::uint32_t blind = ~in_row & ((1U << count) - 1) << place.x;
#pragma GCC unroll 1
  for (; blind != 0; blind &= blind - 1) {
    const int x = __builtin_ctz(blind);
    const std::uint32_t in_column = s.column_bits[x];
    const int left = before(in_row, x);
    const int right = behind(in_row, x);
    const int above = before(in_column, y);
    const int below = behind(in_column, y);
    const std::uint32_t beside =
        least(left < 0 ? s.outside[0][y] : s.raw[y][left], right < 0 ? s.outside[1][y] : s.raw[y][right]);
    const std::uint32_t upright =
        least(above < 0 ? s.outside[2][x] : s.raw[above][x], below < 0 ? s.outside[3][x] : s.raw[below][x]);
    s.raw[y][x] = static_cast<std::uint16_t>(least(beside, upright));
  }
}

/// The end of a pixel without a reading: a weak one.
inline G3D_GPU std::uint32_t weak_end(const FrameParams& f, std::uint32_t nearest, std::uint32_t mask) {
  const bool carves =
      f.carve_invalid != 0 && nearest != kUnbounded && nearest >= static_cast<std::uint32_t>(f.near_raw);
  return carves ? least(mask, nearest) : 0U;
}

/// Of a measured one.
inline G3D_GPU std::uint32_t strong_end(const FrameParams& f, std::uint32_t reading) {
  return reading >= static_cast<std::uint32_t>(f.near_raw) ? least(reading, static_cast<std::uint32_t>(f.far_raw)) : 0U;
}

/// How many readings there are of each kind among up to a thousand: trusted, too near, too far.
[[nodiscard]] constexpr std::uint32_t kind_of(const FrameParams& f, int reading) {
  if (reading == 0) return 0;
  return reading < f.near_raw ? 1U << 10 : reading > f.far_raw ? 1U << 20 : 1U;
}

}  // namespace g3d::mapper::cuda
