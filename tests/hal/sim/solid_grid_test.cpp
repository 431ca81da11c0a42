// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/solid_grid.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "hal/sim/plan_shape.hpp"
#include "hal/sim/seeded_random.hpp"

using namespace g3d::hal;

TEST_CASE("everything within the margin is listed, in ascending order") {
  SeededRandom random(7);
  World world;
  std::vector<std::int32_t> all;
  for (int i = 0; i < 200; ++i) {
    world.add_box({20 * random.uniform(), 12 * random.uniform(), 0},
                  {0.02 + 3 * random.uniform() * random.uniform(), 0.05 + random.uniform(), 1}, 360 * random.uniform(),
                  {});
    all.push_back(i);
  }
  const SolidGrid grid(world, all, 0.4);
  std::size_t listed = 0;
  for (int n = 0; n < 2000; ++n) {
    const double x = -1 + 22 * random.uniform();
    const double y = -1 + 14 * random.uniform();
    const auto near = grid.near(x, y);
    REQUIRE(std::is_sorted(near.begin(), near.end()));
    listed += near.size();
    for (const std::int32_t i : all) {
      const Primitive& p = world.primitives()[static_cast<std::size_t>(i)];
      if (nearest_in_plan(p, {0, 1}, x, y).distance_m >= 0.4) continue;
      REQUIRE(std::binary_search(near.begin(), near.end(), i));
    }
  }
  CHECK(listed / 2000.0 < 40.0);
}

TEST_CASE("a hostile number of huge solids stays within memory") {
  World world;
  std::vector<std::int32_t> all;
  for (int i = 0; i < 4096; ++i) {
    world.add_box({0, 0, 0}, {1000, 1000, 1}, i, {});
    all.push_back(i);
  }
  const SolidGrid grid(world, all, 0.6);
  CHECK(grid.near(0, 0).size() == 4096);
}

TEST_CASE("without solids nothing is near") {
  const World world;
  CHECK(SolidGrid(world, {}, 1.0).near(0, 0).empty());
}
