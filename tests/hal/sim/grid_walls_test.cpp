// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/grid_walls.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

using g3d::hal::GridWalls;

namespace {

GridWalls random_grid(int width, int height, double density, unsigned seed) {
  std::mt19937 rng(seed);
  std::vector<std::uint8_t> solid(static_cast<std::size_t>(width * height));
  for (auto& cell : solid) cell = std::uniform_real_distribution<>(0, 1)(rng) < density;
  return GridWalls(width, height, 0.1F, {-1.0F, -2.0F}, 0.0F, 2.0F, solid);
}

/// The slow plain version: every solid cell as a box, nearest entry, in double.
double nearest_box(const GridWalls& grid, const std::array<float, 3>& o, const std::array<float, 3>& d) {
  double best = 1e30;
  for (int j = 0; j < grid.height_cells(); ++j) {
    for (int i = 0; i < grid.width_cells(); ++i) {
      if (!grid.is_solid_cell(i, j)) continue;
      const double low[3] = {grid.origin_m()[0] + double(grid.cell_m()) * i,
                             grid.origin_m()[1] + double(grid.cell_m()) * j, grid.z_low_m()};
      const double high[3] = {low[0] + grid.cell_m(), low[1] + grid.cell_m(), grid.z_high_m()};
      double from = 0.0;
      double to = 1e30;
      for (std::size_t k = 0; k < 3; ++k) {
        const double inverse = 1.0 / (d[k] == 0.0F ? 1e-12 : d[k]);
        const double a = (low[k] - o[k]) * inverse;
        const double b = (high[k] - o[k]) * inverse;
        from = std::max(from, std::min(a, b));
        to = std::min(to, std::max(a, b));
      }
      if (from <= to) best = std::min(best, from);
    }
  }
  return best;
}

}  // namespace

TEST_CASE("the chessboard distance is what a search over all cells finds") {
  const GridWalls grid = random_grid(40, 30, 0.02, 3);
  for (int j = 0; j < 30; ++j) {
    for (int i = 0; i < 40; ++i) {
      int nearest = 255;
      for (int y = 0; y < 30; ++y) {
        for (int x = 0; x < 40; ++x) {
          if (grid.is_solid_cell(x, y)) nearest = std::min(nearest, std::max(std::abs(x - i), std::abs(y - j)));
        }
      }
      REQUIRE(grid.distance(i, j) == nearest);
    }
  }
}

TEST_CASE("a ray through the grid meets the same wall as a search over all cells") {
  for (const double density : {0.01, 0.1, 0.4}) {
    const GridWalls grid = random_grid(50, 40, density, 7);
    std::mt19937 rng(11);
    std::uniform_real_distribution<float> place(-1.5F, 4.5F);
    std::uniform_real_distribution<float> height(-0.5F, 2.8F);
    std::uniform_real_distribution<float> way(-1.0F, 1.0F);
    int differ = 0;
    for (int n = 0; n < 2000; ++n) {
      const std::array<float, 3> o = {place(rng), place(rng) - 1.0F, height(rng)};
      std::array<float, 3> d = {way(rng), way(rng), 0.4F * way(rng)};
      if (n % 10 == 0) d[static_cast<std::size_t>(n / 10 % 3)] = 0.0F;
      const double expected = nearest_box(grid, o, d);
      const float got = grid.cast(o, d, GridWalls::kMiss).t;
      if (expected > 1e29 ? got < 1e29F : std::abs(got - expected) > 1e-3) ++differ;
    }
    // Rays that graze a corner may go either way.
    CHECK(differ <= 4);
  }
}

TEST_CASE("a ray ends at its limit and tells the face it hit") {
  std::vector<std::uint8_t> solid(100, 0);
  solid[5 * 10 + 8] = 1;
  const GridWalls grid(10, 10, 1.0F, {0.0F, 0.0F}, 0.0F, 2.0F, solid);
  const auto hit = grid.cast({1.0F, 5.5F, 1.0F}, {1.0F, 0.0F, 0.0F}, 100.0F);
  CHECK(hit.t == Approx(7.0));
  CHECK(hit.axis == 0);
  CHECK(grid.cast({1.0F, 5.5F, 1.0F}, {1.0F, 0.0F, 0.0F}, 6.9F).t == GridWalls::kMiss);
  CHECK(grid.cast({8.5F, 0.5F, 1.0F}, {0.0F, 2.0F, 0.0F}, 100.0F).axis == 1);
  const auto top = grid.cast({8.5F, 5.5F, 5.0F}, {0.0F, 0.0F, -1.0F}, 100.0F);
  CHECK(top.t == Approx(3.0));
  CHECK(top.axis == 2);
  CHECK(grid.is_solid(8.5F, 5.5F, 1.0F));
  CHECK_FALSE(grid.is_solid(8.5F, 5.5F, 2.5F));
  CHECK_FALSE(grid.is_solid(7.5F, 5.5F, 1.0F));
  CHECK_FALSE(grid.is_solid(-3.0F, 5.5F, 1.0F));
}
