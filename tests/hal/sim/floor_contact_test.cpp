// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/floor_contact.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "hal/sim/load_world.hpp"
#include "hal/sim/seeded_random.hpp"
#include "hal/sim/world_file.hpp"

using namespace g3d::hal;

TEST_CASE("the nearest thing is the one that a search through all solids finds") {
  const World world = load_world("furnished_room").value();
  const FloorContact floor(world);
  SeededRandom random(3);
  const HeightSlice slice{kClimb_m, 0.6};
  for (int n = 0; n < 3000; ++n) {
    const double x = -5 + 10 * random.uniform();
    const double y = -5 + 10 * random.uniform();
    double expected = 1e9;
    for (const Primitive& p : world.primitives()) {
      if (upper_side_m(p) > kClimb_m) expected = std::min(expected, nearest_in_plan(p, slice, x, y).distance_m);
    }
    const auto thing = floor.nearest(x, y, slice, {}, -1);
    if (expected < FloorContact::kReach_m) {
      REQUIRE(thing.at.distance_m == expected);
      REQUIRE(thing.kind == FloorContact::Kind::solid);
    } else {
      REQUIRE(thing.kind == FloorContact::Kind::nothing);
    }
  }
}

TEST_CASE("walls of a grid are met at the edge of their cells") {
  World world;
  std::vector<std::uint8_t> solid(40 * 40, 0);
  solid[20 * 40 + 30] = 1;  // x 1.5..1.55, y 1.0..1.05
  world.set_grid(GridWalls(40, 40, 0.05F, {0.0F, 0.0F}, 0.0F, 2.5F, solid));
  const FloorContact floor(world);
  const auto thing = floor.nearest(1.2, 1.02, {0.02, 0.6}, {}, -1);
  CHECK(thing.kind == FloorContact::Kind::grid);
  CHECK(thing.at.distance_m == Approx(0.3).margin(1e-6));
  CHECK(thing.at.x_m == Approx(1.5));
  CHECK(floor.nearest(1.55 + 0.3, 1.05 + 0.4, {0.02, 0.6}, {}, -1).at.distance_m == Approx(0.5).margin(1e-6));
  CHECK(floor.nearest(0.5, 1.02, {0.02, 0.6}, {}, -1).kind == FloorContact::Kind::nothing);
  CHECK(floor.nearest(-0.2, 1.0, {0.02, 0.6}, {}, -1).kind == FloorContact::Kind::nothing);
  CHECK(floor.nearest(1.2, 1.02, {2.6, 3.0}, {}, -1).kind == FloorContact::Kind::nothing);
}

TEST_CASE("movers are met where the caller says they are, but not oneself") {
  World world;
  const std::size_t mover = world.add_moving_cylinder(0.0, 0.2, 0.6, {});
  const FloorContact floor(world);
  const std::array<std::array<float, 2>, 1> places = {{{2.0F, 1.0F}}};
  const auto thing = floor.nearest(1.5, 1.0, {0.02, 0.6}, places, -1);
  CHECK(thing.at.distance_m == Approx(0.3));
  CHECK(thing.mover == static_cast<std::int32_t>(mover));
  CHECK(floor.nearest(1.5, 1.0, {0.02, 0.6}, places, 0).kind == FloorContact::Kind::nothing);
}

TEST_CASE("the floor is the highest surface that wheels roll on, and ends at its edge") {
  const World world = parse_world(
                          "floor 0 0 0  4 4 0.1\n"
                          "box 0 0 0  1 1 0.012\n"        // a rug
                          "box 1.5 1.5 0  0.5 0.5 0.4\n"  // a box is no floor
                          "floor 4 0 -0.17  4 4 0.1\n",   // one step down
                          "w")
                          .value();
  const FloorContact floor(world);
  CHECK(floor.floor_m(-1.5, 0) == Approx(0.0).margin(1e-6));
  CHECK(floor.floor_m(0.2, 0.2) == Approx(0.012));
  CHECK(floor.floor_m(1.5, 1.5) == Approx(0.0).margin(1e-6));
  CHECK(floor.floor_m(2.5, 0) == Approx(-0.17));
  CHECK(floor.floor_m(0, 2.5) == kNoFloor_m);
}
