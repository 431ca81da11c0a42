// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/reach.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "hal/sim/load_world.hpp"
#include "hal/sim/world_file.hpp"

using namespace g3d::hal;

namespace {

double reachable_m2(const char* text, const PlanarPose& start) {
  const World world = parse_world(text, "w").value();
  const PlanFrame frame = plan_frame(world).value();
  const auto cells = reachable_cells(FloorContact(world), frame, std::span(&start, 1));
  return static_cast<double>(std::count(cells.begin(), cells.end(), 1)) * 0.0025;
}

}  // namespace

TEST_CASE("the cells of a floor plan lie on multiples of their side") {
  const World world = parse_world("floor 0.01 0 0  2 1 0.1\n", "w").value();
  const PlanFrame frame = plan_frame(world).value();
  CHECK(frame.first_x == -20);
  CHECK(frame.columns == 41);
  CHECK(frame.column_of(-0.999) == 0);
  CHECK(frame.column_of(0.0) == 20);
  CHECK(frame.x_m(20) == Approx(0.025));
  CHECK(frame.y_m(frame.row_of(0.31)) == Approx(0.325));
  CHECK_FALSE(plan_frame(parse_world("box 0 0 0 1000 1000 1\n", "w").value()).ok());
}

TEST_CASE("a robot reaches what its body has room for") {
  const char* room = "room 0 0 0  4 4 2.5 0.1\n";
  CHECK(reachable_m2(room, {0, 0, 0}) == Approx(3.64 * 3.64).margin(0.4));
  CHECK(reachable_m2(room, {1.95, 0, 0}) == 0.0);
  const std::string wall = std::string(room) + "box -1.3 0 0  1.4 0.1 2\nbox 1.3 0 0 1.4 0.1 2\n";
  // A gap of 1.2 m in the middle, then of 0.34 and 0.46 m.
  CHECK(reachable_m2(wall.c_str(), {0, -1, 0}) > 11.0);
  CHECK(reachable_m2((wall + "box -0.385 0 0 0.43 0.1 2\nbox 0.385 0 0 0.43 0.1 2\n").c_str(), {0, -1, 0}) < 6.2);
  CHECK(reachable_m2((wall + "box -0.415 0 0 0.37 0.1 2\nbox 0.415 0 0 0.37 0.1 2\n").c_str(), {0, -1, 0}) > 10.5);
  // Under a table, over a rug, but not over a hole's edge.
  CHECK(reachable_m2((std::string(room) + "box 0 0 0.7 3 3 0.05\nbox 0 0 0 2 2 0.015\n").c_str(), {0, 0, 0}) > 12.5);
  CHECK(reachable_m2("floor -2 0 0  4 4 0.1\nfloor 2 0 -0.2  4 4 0.1\n", {-2, 0, 0}) ==
        Approx(3.64 * 3.64).margin(0.4));
}

TEST_CASE("starts are the world's own, or drawn by seed from what is reachable") {
  const World world = load_world("house").value();
  const auto own = choose_starts(world, 2, 1).value();
  CHECK(own[0] == world.starts()[0]);
  CHECK(own[1] == world.starts()[1]);
  const auto drawn = choose_starts(world, 3, 7).value();
  CHECK(drawn == choose_starts(world, 3, 7).value());
  CHECK(drawn != choose_starts(world, 3, 8).value());
  const FloorContact floor(world);
  const PlanFrame frame = plan_frame(world).value();
  const auto reached = reachable_cells(floor, frame, std::span(&own[0], 1));
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    CHECK(reached[frame.index(frame.column_of(drawn[i].x_m), frame.row_of(drawn[i].y_m))] == 1);
    CHECK(floor.nearest(drawn[i].x_m, drawn[i].y_m, {0.02, 0.6}, {}, -1).at.distance_m >= 0.28);
    for (std::size_t j = 0; j < i; ++j) {
      CHECK(std::hypot(drawn[i].x_m - drawn[j].x_m, drawn[i].y_m - drawn[j].y_m) >= 0.6);
    }
  }
}

TEST_CASE("a world without starts is entered in its widest part, a full one is refused") {
  const World world = parse_world("room 0 0 0  6 6 2.5 0.1\nroom 10 0 0  2 2 2.5 0.1\n", "w").value();
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    const auto starts = choose_starts(world, 1, seed).value();
    CHECK(starts[0].x_m < 3.0);
  }
  const World full = parse_world("room 0 0 0  0.7 0.7 2.5 0.1\n", "w").value();
  CHECK(choose_starts(full, 1, 3).ok());
  CHECK(choose_starts(full, 2, 3).error().reason == Reason::no_capacity);
}

TEST_CASE("a start within a wall is refused, and named") {
  const World world = parse_world("room 0 0 0  4 4 2.5 0.1\nstart 0 0 0\nstart 1.9 0 0\n", "w").value();
  for (const std::uint64_t seed : {1U, 2U}) {
    const auto starts = choose_starts(world, 1, seed);
    REQUIRE_FALSE(starts.ok());
    CHECK(starts.error().reason == Reason::bad_usage);
    CHECK_THAT(starts.error().text, Catch::Matchers::Contains("start 2 of the world, (1.90, 0.00)"));
  }
}

TEST_CASE("a seed is the same start for every compiler") {
  const World room = load_world("furnished_room").value();
  const PlanarPose start = choose_starts(room, 1, 2).value()[0];
  CHECK(start.x_m == Approx(0.875));
  CHECK(start.y_m == Approx(-2.575));
}
