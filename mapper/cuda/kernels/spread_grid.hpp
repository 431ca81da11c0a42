// SPDX-License-Identifier: Apache-2.0
// Travel costs over a grid, round by round: a block of threads takes a tile of it into its own memory, lets every cell
// look at its neighbours until nothing improves there, and wakes the tiles beside it that what it found concerns. Costs
// only fall, and the lowest ones are what they are, so the end does not depend on who comes first.
#pragma once

#include "mapper/cuda/kernels/common.hpp"

namespace g3d::mapper::cuda {

inline constexpr int kSpreadTile = 32;               ///< cells along a side
inline constexpr int kSpreadSide = kSpreadTile + 2;  ///< with one neighbour on each side
inline constexpr int kSpreadCells = kSpreadSide * kSpreadSide;
inline constexpr int kSpreadRows = kSpreadTile * kSpreadTile / kPixelThreads;  ///< of a thread, in its column

struct SpreadTile {
  std::uint32_t distance[kSpreadCells];
  std::uint8_t cost[kSpreadCells];
  std::uint32_t improved[3];  ///< of three sweeps in turn
  std::uint32_t wakes;        ///< bit 3 (dy + 1) + dx + 1: the tile there
  std::uint32_t is_awake;
};

inline G3D_GPU void begin_spread(const Block& block, const Memory& m) {
  const GridSpread& ask = *m.spread;
  const int cells = ask.columns * ask.rows;
  const int across = tiles(ask.columns, kSpreadTile);
  const int all = across * tiles(ask.rows, kSpreadTile);
  block.lanes([&](int t) {
    const int first = block.index * kPixelThreads + t;
    const int stride = block.count * kPixelThreads;
    const int start = ask.start_y * ask.columns + ask.start_x;
    const int start_tile = ask.start_y / kSpreadTile * across + ask.start_x / kSpreadTile;
    for (int i = first; i < cells; i += stride) m.grid_distances[i] = i == start ? 0 : kNotReached;
    for (int i = first; i < all; i += stride) {
      m.awake[0][i] = i == start_tile ? 1 : 0;
      m.awake[1][i] = 0;
    }
    if (first < 3) m.awake_counts[first] = first == 0 ? 1 : 0;
  });
}

/// The cheapest way into a cell of the tile, by what its neighbours say.
inline G3D_GPU std::uint32_t cheapest(const GridSpread& ask, const SpreadTile& s, int place, int x, int y) {
  std::uint32_t best = s.distance[place];
  const std::uint8_t cost = s.cost[place];
#pragma GCC unroll 1
  for (int d = 0; d < 9; ++d) {
    const int dx = d % 3 - 1;  // of the step into the cell
    const int dy = d / 3 - 1;
    const int from = place - dy * kSpreadSide - dx;
    const std::uint32_t known = s.distance[from];
    if (known >= best) continue;  // itself as well
    const int far_x = x - dx - ask.start_x;
    const int far_y = y - dy - ask.start_y;
    const int reach = most(most(far_x, -far_x), most(far_y, -far_y));
    const StepPrices& prices = ask.prices[reach <= ask.relief_cells ? 1 : 0];
    std::uint32_t price = 0;
    if (dx == 0 || dy == 0) {
      price = prices.straight[cost];
    } else if (prices.straight[s.cost[from + dx]] != 0 && prices.straight[s.cost[place - dx]] != 0) {
      price = prices.diagonal[cost];
    }
    if (price != 0 && known + price <= ask.max_cost) best = least(best, known + price);
  }
  return best;
}

inline G3D_GPU void spread_tile(const Block& block, const Memory& m, SpreadTile& s, int tile, std::uint32_t round) {
  const GridSpread& ask = *m.spread;
  const int across = tiles(ask.columns, kSpreadTile);
  const int down = tiles(ask.rows, kSpreadTile);
  const int tile_x = tile % across;
  const int tile_y = tile / across;
  block.each([&](int t) {
    for (int i = t; i < kSpreadCells; i += kPixelThreads) {
      const int x = tile_x * kSpreadTile + i % kSpreadSide - 1;
      const int y = tile_y * kSpreadTile + i / kSpreadSide - 1;
      const bool inside = x >= 0 && y >= 0 && x < ask.columns && y < ask.rows;
      s.distance[i] = inside ? m.grid_distances[y * ask.columns + x] : kNotReached;
      s.cost[i] = inside ? m.grid_costs[y * ask.columns + x] : 0;
    }
    if (t < 3) s.improved[t] = 0;
    if (t == 3) s.wakes = 0;
  });
  const auto for_own = [&](int t, auto&& visit) {
#pragma GCC unroll 4
    for (int i = 0; i < kSpreadRows; ++i) {
      const int in_x = t % kSpreadTile;
      const int in_y = t / kSpreadTile * kSpreadRows + i;
      const int x = tile_x * kSpreadTile + in_x;
      const int y = tile_y * kSpreadTile + in_y;
      if (x < ask.columns && y < ask.rows) visit((in_y + 1) * kSpreadSide + in_x + 1, in_x, in_y, x, y, i);
    }
  };
  PerThread<std::uint32_t, kPixelThreads> best[kSpreadRows];
  for (int sweep = 0;; ++sweep) {
    block.each([&](int t) {
      if (t == 0) s.improved[(sweep + 1) % 3] = 0;
      for_own(t, [&](int place, int, int, int x, int y, int i) { best[i][t] = cheapest(ask, s, place, x, y); });
    });
    block.each([&](int t) {
      bool improved = false;
      for_own(t, [&](int place, int, int, int, int, int i) {
        improved |= best[i][t] < s.distance[place];
        s.distance[place] = best[i][t];
      });
      if (improved) atomic_or(&s.improved[sweep % 3], 1U);
    });
    if (s.improved[sweep % 3] == 0) break;
  }
  block.each([&](int t) {
    for_own(t, [&](int place, int in_x, int in_y, int x, int y, int) {
      std::uint32_t& known = m.grid_distances[y * ask.columns + x];
      if (s.distance[place] >= known) return;
      known = s.distance[place];
      const int dx = in_x == 0 ? -1 : in_x == kSpreadTile - 1 ? 1 : 0;
      const int dy = in_y == 0 ? -1 : in_y == kSpreadTile - 1 ? 1 : 0;
      const std::uint32_t wakes =
          1U << (dx + 4) | 1U << (3 * dy + 4) | 1U << (3 * dy + dx + 4);  // bit 4 is this tile: nothing
      if (wakes != 1U << 4) atomic_or(&s.wakes, wakes);
    });
  });
  block.each([&](int t) {
    if (t >= 9 || t == 4 || (s.wakes >> t & 1U) == 0) return;
    const int x = tile_x + t % 3 - 1;
    const int y = tile_y + t / 3 - 1;
    if (x < 0 || y < 0 || x >= across || y >= down) return;
    const std::uint32_t next = (round + 1) % 2;
    if (atomic_or(m.awake[next] + y * across + x, 1U) == 0) atomic_add(m.awake_counts + (round + 1) % 3, 1U);
  });
}

/// All tiles that are awake, once.
inline G3D_GPU void spread_round(const Block& block, const Memory& m, std::uint32_t round) {
  G3D_GPU_SHARED SpreadTile s;
  if (m.awake_counts[round % 3] == 0) return;
  const GridSpread& ask = *m.spread;
  const int all = tiles(ask.columns, kSpreadTile) * tiles(ask.rows, kSpreadTile);
  if (block.index == 0) {
    block.lanes([&](int t) {
      if (t == 0) m.awake_counts[(round + 2) % 3] = 0;
    });
  }
  for (int tile = block.index; tile < all; tile += block.count) {
    block.each([&](int t) {
      if (t != 0) return;
      s.is_awake = m.awake[round % 2][tile];
      m.awake[round % 2][tile] = 0;
    });
    const bool is_awake = s.is_awake != 0;
    if (is_awake) spread_tile(block, m, s, tile, round);
    block.each([](int) {});  // all have read is_awake
  }
}

}  // namespace g3d::mapper::cuda
