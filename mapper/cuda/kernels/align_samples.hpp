// SPDX-License-Identifier: Apache-2.0
// The samples of a frame, as align::DepthSamples makes them: a thread for each tile of the image.
//
//   read_tiles     depths of tiles | the last frame's cubes and state are cleared
//   find_samples   normals | the first tile of each cube
//   count_chosen   how many of each chunk of tiles are the first in their cubes
//   choose         these, in order
#pragma once

#include "mapper/cuda/kernels/common.hpp"

namespace g3d::mapper::cuda {

template <typename F>
inline G3D_GPU void for_tiles(const Block& block, std::uint32_t count, F&& visit) {
  block.lanes([&](int t) {
    const auto stride = static_cast<std::uint32_t>(block.count * kPixelThreads);
    for (std::uint32_t i = static_cast<std::uint32_t>(block.index * kPixelThreads + t); i < count; i += stride) {
      visit(i);
    }
  });
}
inline G3D_GPU std::uint32_t tiles_of(const align::SampleShape& shape) {
  return static_cast<std::uint32_t>(shape.columns * shape.rows);
}

inline G3D_GPU void begin_fit(AlignState& state, const align::FitQuestion& fit) {
  state.chosen = state.steps = state.ended = state.touched = state.refused = 0;
  state.pose = fit.predicted;
  state.T_world_camera = hal::to_transform(fit.predicted);
}

inline G3D_GPU void read_tiles(const Block& block, const Memory& m) {
  const AlignMemory& a = m.align;
  const align::SampleShape& shape = a.question->shape;
  for_tiles(block, tiles_of(shape), [&](std::uint32_t i) {
    const auto column = static_cast<int>(i) % shape.columns;
    const auto row = static_cast<int>(i) / shape.columns;
    const std::uint16_t* tile = m.depth + static_cast<std::size_t>(row * shape.tile_px * shape.width_px) +
                                static_cast<std::size_t>(column * shape.tile_px);
    a.inverse_depth[i] = align::inverse_depth_of_tile(
        shape.tile_px, [&](int x, int y) { return align::inverse_of(shape, tile[y * shape.width_px + x]); });
  });
  for_tiles(block, a.cube_mask + 1, [&](std::uint32_t i) {
    a.cube_keys[i] = 0;
    a.cube_firsts[i] = kNone;
  });
  for_tiles(block, kMostFitSteps + 1, [&](std::uint32_t i) {
    a.state->arrived[i] = 0;
    a.state->sums[i] = {};
    if (i == 0) begin_fit(*a.state, a.question->fit);
  });
}

/// The place of a cube in its table, which is at most half full.
inline G3D_GPU std::uint32_t place_of_cube(const AlignMemory& a, std::uint64_t key) {
  auto at = static_cast<std::uint32_t>((key * 0x9E3779B97F4A7C15ULL) >> 40) & a.cube_mask;
  for (;;) {
    const std::uint64_t before = atomic_cas(a.cube_keys + at, std::uint64_t{0}, key);
    if (before == 0 || before == key) return at;
    at = (at + 1) & a.cube_mask;
  }
}

inline G3D_GPU void find_samples(const Block& block, const Memory& m) {
  const AlignMemory& a = m.align;
  const align::SampleShape& shape = a.question->shape;
  constexpr int k = align::kNormalReach_tiles;
  for_tiles(block, tiles_of(shape), [&](std::uint32_t i) {
    const auto c = static_cast<int>(i) % shape.columns;
    const auto r = static_cast<int>(i) / shape.columns;
    align::DepthSample sample;
    bool is_there = false;
    if (c >= k && r >= k && c < shape.columns - k && r < shape.rows - k) {
      const auto at = [&](int row, int column) { return a.inverse_depth[row * shape.columns + column]; };
      const align::TileCross cross{at(r, c),
                                   at(r, c - k),
                                   at(r, c + k),
                                   at(r - k, c),
                                   at(r + k, c),
                                   align::slope_of_column(shape, c),
                                   align::slope_of_column(shape, c - k),
                                   align::slope_of_column(shape, c + k),
                                   align::slope_of_row(shape, r),
                                   align::slope_of_row(shape, r - k),
                                   align::slope_of_row(shape, r + k)};
      is_there = align::sample_of(cross, sample);
    }
    std::uint32_t cube = kNone;
    if (is_there) {
      cube = place_of_cube(a, align::cube_of(sample.point_m, shape.spacing_m));
      atomic_min(a.cube_firsts + cube, i);
    } else {
      sample.weight = 0.0F;
    }
    a.samples[i] = sample;
    a.sample_cube[i] = cube;
  });
}

inline G3D_GPU bool is_chosen(const AlignMemory& a, std::uint32_t tile, std::uint32_t count) {
  return tile < count && a.sample_cube[tile] != kNone && a.cube_firsts[a.sample_cube[tile]] == tile;
}

struct ChosenShare {
  std::uint32_t before[kAlignChunk];
  std::uint32_t of_warp[kAlignChunk / 32];
};

/// Which of a chunk's tiles are chosen, and how many of each warp's.
inline G3D_GPU void mark_chosen(const Block& block, const AlignMemory& a, std::uint32_t chunk, std::uint32_t count,
                                PerThread<std::uint32_t, kPixelThreads>& wants, ChosenShare& s) {
  block.lanes(
      [&](int t) { wants[t] = is_chosen(a, chunk * kAlignChunk + static_cast<std::uint32_t>(t), count) ? 1 : 0; });
  block.each([&](int t) {
    const std::uint32_t lanes = wants.ballot(t);
    if (t % 32 == 0) s.of_warp[t / 32] = static_cast<std::uint32_t>(__builtin_popcount(lanes));
  });
}

inline G3D_GPU void count_chosen(const Block& block, const Memory& m) {
  static_assert(kAlignChunk == kPixelThreads);
  G3D_GPU_SHARED ChosenShare s;
  const AlignMemory& a = m.align;
  const std::uint32_t count = tiles_of(a.question->shape);
  PerThread<std::uint32_t, kPixelThreads> wants;
  for (auto chunk = static_cast<std::uint32_t>(block.index); chunk * kAlignChunk < count;
       chunk += static_cast<std::uint32_t>(block.count)) {
    mark_chosen(block, a, chunk, count, wants, s);
    block.each([&](int t) {
      if (t != 0) return;
      std::uint32_t sum = 0;
      for (const std::uint32_t warp : s.of_warp) sum += warp;
      a.chunk_counts[chunk] = sum;
    });
  }
}

inline G3D_GPU void choose(const Block& block, const Memory& m) {
  G3D_GPU_SHARED ChosenShare s;
  const AlignMemory& a = m.align;
  const align::SampleShape& shape = a.question->shape;
  const std::uint32_t count = tiles_of(shape);
  const auto room = static_cast<std::uint32_t>(shape.most_chosen);
  PerThread<std::uint32_t, kPixelThreads> wants;
  for (auto chunk = static_cast<std::uint32_t>(block.index); chunk * kAlignChunk < count;
       chunk += static_cast<std::uint32_t>(block.count)) {
    block.each([&](int t) {
      std::uint32_t before = 0;
      for (auto i = static_cast<std::uint32_t>(t); i < chunk; i += kAlignChunk) before += a.chunk_counts[i];
      s.before[t] = before;
    });
    for (int half = kAlignChunk / 2; half > 0; half /= 2) {
      block.each([&](int t) {
        if (t < half) s.before[t] += s.before[t + half];
      });
    }
    mark_chosen(block, a, chunk, count, wants, s);
    block.each([&](int t) {
      const std::uint32_t lanes = wants.ballot(t);
      const std::uint32_t tile = chunk * kAlignChunk + static_cast<std::uint32_t>(t);
      std::uint32_t place =
          s.before[0] + static_cast<std::uint32_t>(__builtin_popcount(lanes & ((1U << (t % 32)) - 1)));
      for (int warp = 0; warp < t / 32; ++warp) place += s.of_warp[warp];
      if (wants[t] != 0 && place < room) a.chosen[place] = a.samples[tile];
      // The last tile's thread knows how many there are in all.
      if (tile + 1 == count) a.state->chosen = least(place + wants[t], room);
    });
  }
}

}  // namespace g3d::mapper::cuda
