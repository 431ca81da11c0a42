// SPDX-License-Identifier: Apache-2.0
// From readings to what blocks and voxels look up: ray ends, maxima of 2x2 cells level by level, minima beside them
// (the depth pyramid), and maxima over windows. A window of 4..7 cells is the maximum of four windows of 4 that
// overlap, so two images per level replace the CPU twin's seven: looking four times costs a card less than making them.
#pragma once

#include "mapper/cuda/kernels/ray_ends.hpp"

namespace g3d::mapper::cuda {

inline constexpr std::uint32_t kNoLow = 0xFFFF;

/// Lowest and highest of some ends in one word.
[[nodiscard]] constexpr std::uint32_t pack_ends(std::uint32_t low, std::uint32_t high) { return low | high << 16; }
[[nodiscard]] constexpr std::uint32_t join_ends(std::uint32_t a, std::uint32_t b) {
  return least(a & 0xFFFFU, b & 0xFFFFU) | most(a & 0xFFFF0000U, b & 0xFFFF0000U);
}

[[nodiscard]] constexpr CellEnds join(const CellEnds& a, const CellEnds& b) {
  return {join_ends(a.ends, b.ends), most(a.strong, b.strong)};
}
inline constexpr CellEnds kNoEnds{kNoLow, 0};

inline G3D_GPU void store_cell(const FrameParams& f, const Memory& m, int level, int x, int y, const CellEnds& cell) {
  const ImageShape& shape = f.shapes[level];
  if (x >= shape.width || y >= shape.height) return;
  if ((f.wanted_images >> level & 3U) != 0) {  // level 6 is made of level 5
    const int place = (y + kPadding) * shape.stride + x + kPadding;
    m.ends[level][place] = static_cast<std::uint16_t>(cell.ends >> 16);
    m.strong[level][place] = static_cast<std::uint16_t>(cell.strong);
  }
  if (level >= kBaseLevel) m.pyramid[level - kBaseLevel][y * shape.width + x] = cell.ends;
}

/// A cell of each thread, for others of its warp.
struct SharedCells {
  PerThread<std::uint32_t, kPixelThreads> ends;
  PerThread<std::uint32_t, kPixelThreads> strong;
};
inline G3D_GPU void tell(SharedCells& cells, int t, const CellEnds& cell) {
  cells.ends[t] = cell.ends;
  cells.strong[t] = cell.strong;
}
inline G3D_GPU CellEnds own(SharedCells& cells, int t) { return {cells.ends[t], cells.strong[t]}; }
inline G3D_GPU CellEnds joined(SharedCells& cells, int t, int bits) {
  return join(own(cells, t), {cells.ends.peer(t, bits), cells.strong.peer(t, bits)});
}

/// Ends of a thread's pixels, to memory and as two cells of 2 x 1 pixels.
inline G3D_GPU void finish_run(const FrameParams& f, const Memory& m, const EndTile& s, const RunPlace& place,
                               const AnyPair& readings, const AnyPair& masks, CellEnds* cells) {
  const int u = place.first_u + place.x;
  const int v = place.first_v + place.y;
  std::uint32_t ends[2] = {0, 0};
  cells[0] = kNoEnds;
  cells[1] = kNoEnds;
#pragma GCC unroll 4
  for (int i = 0; i < kRun_px; ++i) {
    const std::uint32_t reading = half_of(readings, i);
    const std::uint32_t strong = reading != 0 ? strong_end(f, reading) : 0U;
    const std::uint32_t weak = weak_end(f, s.raw[place.y][place.x + i], half_of(masks, i));
    // Beside the image lies padding.
    const std::uint32_t end = reading != 0 ? strong : u + i < f.width_px && v < f.height_px ? weak : 0U;
    ends[i / 2] |= end << (16 * (i % 2));
    cells[i / 2] = join(cells[i / 2], {pack_ends(end, end), strong});
  }
  if (u >= f.width_px || v >= f.height_px) return;
  std::uint16_t* to = m.ends[0] + (v + kPadding) * f.shapes[0].stride + kPadding + u;
  *reinterpret_cast<AnyPair*>(to) = {ends[0], ends[1]};
}

/// Levels 3 to 5 of a tile by its first sixteen threads.
inline G3D_GPU void finish_tile(const Block& block, const Memory& m, const FrameParams& f, const EndTile& s, int tile) {
  SharedCells cells[2];
  block.lanes([&](int t) {
    const int x = t % 4 * 2;
    const int y = t / 4 % 4 * 2;
    tell(cells[0], t, join(join(s.cells[y][x], s.cells[y][x + 1]), join(s.cells[y + 1][x], s.cells[y + 1][x + 1])));
  });
  block.lanes([&](int t) {
    const RunPlace place = run_of(f, tile, t);
    if (t < 16) store_cell(f, m, 3, place.first_u / 8 + t % 4, place.first_v / 8 + t / 4, own(cells[0], t));
    tell(cells[1], t, joined(cells[0], t, 1));
  });
  block.lanes([&](int t) { tell(cells[0], t, joined(cells[1], t, 4)); });
  block.lanes([&](int t) {
    const RunPlace place = run_of(f, tile, t);
    if (t < 16 && (t & 5) == 0) {
      store_cell(f, m, 4, place.first_u / 16 + t % 4 / 2, place.first_v / 16 + t / 8, own(cells[0], t));
    }
    tell(cells[1], t, joined(cells[0], t, 2));
  });
  block.lanes([&](int t) {
    const RunPlace place = run_of(f, tile, t);
    const CellEnds cell = joined(cells[1], t, 8);
    if (t == 0) store_cell(f, m, 5, place.first_u / 32, place.first_v / 32, cell);
  });
}

/// 32 x 32 pixels: from readings to all levels of their ends.
inline G3D_GPU void read_tile(const Block& block, const Memory& m, const FrameParams& f, int tile) {
  G3D_GPU_SHARED EndTile s;
  PerThread<AnyPair, kPixelThreads> readings;
  PerThread<AnyPair, kPixelThreads> masks;
  PerThread<std::uint32_t, kPixelThreads> kinds[2];
  block.each([&](int t) {
    const RunPlace place = run_of(f, tile, t);
    readings[t] = read_four(f, m.depth, place.first_u + place.x, place.first_v + place.y);
    masks[t] = read_four(f, m.mask, place.first_u + place.x, place.first_v + place.y);
    auto* words = reinterpret_cast<AnyWord*>(&s.raw[place.y][place.x]);
    words[0] = readings[t].low;
    words[1] = readings[t].high;
    if (t == 0) s.long_run_count = 0;
    kinds[0][t] = 0;
#pragma GCC unroll 4
    for (int i = 0; i < kRun_px; ++i) kinds[0][t] += kind_of(f, static_cast<int>(half_of(readings[t], i)));
  });
#pragma GCC unroll 5
  for (int i = 0; i < 5; ++i) {
    block.lanes([&](int t) { kinds[(i + 1) % 2][t] = kinds[i % 2][t] + kinds[i % 2].peer(t, 1 << i); });
  }
  // Each warp stands four rows and four columns upright.
#pragma GCC unroll 2
  for (int i = 0; i < 8; ++i) {
    PerThread<std::uint32_t, kPixelThreads> has_reading;
    block.lanes([&](int t) {
      const int line = t / 32 * 4 + i / 2;
      has_reading[t] = i % 2 == 0 ? s.raw[line][t % 32] : s.raw[t % 32][line];
    });
    block.lanes([&](int t) {
      const std::uint32_t bits = has_reading.ballot(t);
      if (t % 32 == 0) (i % 2 == 0 ? s.row_bits : s.column_bits)[t / 32 * 4 + i / 2] = bits;
    });
  }
  block.each([&](int t) {
    if (t % 32 == 0) s.kinds[t / 32] = kinds[1][t];
    if (t < 4 * kTile_px) look_outside(f, m, s, run_of(f, tile, t), t);
  });
  block.each([&](int t) {
    // Each tile has words of its own: atomic operations of all tiles on one word would take longer than all else.
    if (t >= 3) return;
    std::uint32_t sum = 0;
    for (const std::uint32_t kind : s.kinds) sum += kind >> (10 * t) & 1023U;
    m.tile_kinds[4 * tile + t] = sum;
  });
  if (f.free_by == FreeBy::nothing) return;
  block.teams<1>([&](const Team<1>& warp) {
    const int count = static_cast<int>(s.long_run_count);
    for (int run = warp.in_block; run < count; run += kPixelThreads / 32) look_far(warp, f, m, s, tile, run);
  });
  block.each([](int) {});
  SharedCells left;
  SharedCells right;
  block.lanes([&](int t) {
    const RunPlace place = run_of(f, tile, t);
    CellEnds cells[2];
    bound_run(f, s, place);
    finish_run(f, m, s, place, readings[t], masks[t], cells);
    tell(left, t, cells[0]);
    tell(right, t, cells[1]);
  });
  if (f.free_by == FreeBy::projection) {
    // Level 1 by two threads above each other, level 2 by four.
    SharedCells fours;
    block.lanes([&](int t) {
      const RunPlace place = run_of(f, tile, t);
      const CellEnds cells[2] = {joined(left, t, 8), joined(right, t, 8)};
      const bool is_right = place.y % 2 != 0;
      store_cell(f, m, 1, (place.first_u + place.x) / 2 + (is_right ? 1 : 0), (place.first_v + place.y) / 2,
                 is_right ? cells[1] : cells[0]);
      tell(fours, t, join(cells[0], cells[1]));
    });
    block.each([&](int t) {
      const RunPlace place = run_of(f, tile, t);
      const CellEnds cell = joined(fours, t, 16);
      if (place.y % 4 != 0) return;
      const int u = place.first_u + place.x;
      const int v = place.first_v + place.y;
      store_cell(f, m, 2, u / 4, v / 4, cell);
      // A cell wholly outside of the image must not lower those above it.
      s.cells[place.y / 4][place.x / 4] = u < f.width_px && v < f.height_px ? cell : kNoEnds;
    });
    finish_tile(block, m, f, s, tile);
  }
  block.each([](int) {});  // the next tile comes into the same memory
}

inline constexpr int kWindowCellsPerThread = 8;
inline constexpr int kWindowCells = kPixelThreads * kWindowCellsPerThread;
inline constexpr int kTopLevel = kImageLevels - 1;

/// Tasks that level needs, 0 if nobody asks for its windows.
inline G3D_GPU int window_tasks(const FrameParams& f, int level) {
  if ((f.wanted_images >> level & 1U) == 0) return 0;
  return tiles(f.shapes[level].stride * f.shapes[level].rows, level == kTopLevel ? kPixelThreads : kWindowCells);
}

/// Farthest end in some cells of a padded image, as far as there are such.
inline G3D_GPU std::uint32_t farthest_in(const std::uint16_t* image, const ImageShape& shape, int x0, int y0,
                                         int size) {
  std::uint32_t end = 0;
#pragma GCC unroll 1
  for (int y = most(y0, 0); y < least(y0 + size, shape.rows); ++y) {
#pragma GCC unroll 1
    for (int x = most(x0, 0); x < least(x0 + size, shape.stride); ++x) {
      end = most(end, static_cast<std::uint32_t>(image[y * shape.stride + x]));
    }
  }
  return end;
}

/// The coarsest level all at once, from the one below: its cells lie in several tiles.
inline G3D_GPU void fill_top(const Block& block, const Memory& m, const FrameParams& f, int task) {
  const ImageShape& shape = f.shapes[kTopLevel];
  const ImageShape& below = f.shapes[kTopLevel - 1];
  block.lanes([&](int t) {
    const int cell = task * kPixelThreads + t;
    const int x = cell % shape.stride;
    const int y = cell / shape.stride;
    if (y >= shape.rows) return;
    const int below_x = 2 * x - kPadding;
    const int below_y = 2 * y - kPadding;
    const std::uint16_t* ends = m.ends[kTopLevel - 1];
    if (y <= shape.rows - 4)
      m.four[kTopLevel][cell] = static_cast<std::uint16_t>(farthest_in(ends, below, below_x, below_y, 8));
    if (x < kPadding || y < kPadding || x >= kPadding + shape.width || y >= kPadding + shape.height) return;
    m.strong[kTopLevel][cell] =
        static_cast<std::uint16_t>(farthest_in(m.strong[kTopLevel - 1], below, below_x, below_y, 2));
  });
}

/// Some thousand cells of one level's window images, eight neighbours to a thread.
inline G3D_GPU void fill_windows(const Block& block, const Memory& m, const FrameParams& f, int level, int task) {
  const ImageShape& shape = f.shapes[level];
  block.lanes([&](int t) {
    const int cell = task * kWindowCells + t * kWindowCellsPerThread;
    const int x = cell % shape.stride;  // a multiple of 8, as strides are
    const int y = cell / shape.stride;
    if (y > shape.rows - 4) return;
    // From row to row: pairs of neighbours above each other in the first two, the maximum of all four.
    std::uint32_t two[11] = {};
    std::uint32_t tall[11] = {};
#pragma GCC unroll 1
    for (int dy = 0; dy < 4; ++dy) {
      const std::uint16_t* row = m.ends[level] + cell + dy * shape.stride;
      const AnyQuad first = *reinterpret_cast<const AnyQuad*>(row);
      // Beyond the last column there is nothing but padding.
      const AnyPair rest = x + 8 < shape.stride ? *reinterpret_cast<const AnyPair*>(row + 8) : AnyPair{0, 0};
      const std::uint32_t words[6] = {first.words[0], first.words[1], first.words[2],
                                      first.words[3], rest.low,       rest.high};
#pragma GCC unroll 11
      for (int i = 0; i < 11; ++i) {
        const std::uint32_t end = words[i / 2] >> (16 * (i % 2)) & 0xFFFFU;
        tall[i] = most(tall[i], end);
        if (dy == 1) two[i] = tall[i];
      }
    }
    AnyQuad pairs{};
    AnyQuad fours{};
#pragma GCC unroll 8
    for (int i = 0; i < 8; ++i) {
      pairs.words[i / 2] |= most(two[i], two[i + 1]) << (16 * (i % 2));
      fours.words[i / 2] |= most(most(tall[i], tall[i + 1]), most(tall[i + 2], tall[i + 3])) << (16 * (i % 2));
    }
    if (level == 0) *reinterpret_cast<AnyQuad*>(m.two + cell) = pairs;
    *reinterpret_cast<AnyQuad*>(m.four[level] + cell) = fours;
  });
}

}  // namespace g3d::mapper::cuda
