// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>

#include "hal/sim/load_world.hpp"
#include "hal/sim/observable.hpp"

using namespace g3d::hal;

namespace {

Observable observable(const World& world) { return find_observable(world, std::span(world.starts()).first(1)).value(); }

SeenCell at(const Observable& all, double x_m, double y_m) {
  return all.cells[all.frame.index(all.frame.column_of(x_m), all.frame.row_of(y_m))];
}

}  // namespace

TEST_CASE("every room behind a narrow doorway is reached and seen", "[slow]") {
  const World world = load_world("doorways").value();
  const Observable all = observable(world);
  for (const double x : {-3.0, 0.0, 3.0}) {
    for (const double y : {-3.0, 0.0, 2.9}) CHECK(at(all, x, y) == SeenCell::free);
  }
  // A body of 0.62 m does not leave the first room.
  ObservableOptions wide;
  wide.reach.radius_m = 0.31;
  CHECK(find_observable(world, std::span(world.starts()).first(1), wide).value().reachable_count <
        all.reachable_count / 6);
}

TEST_CASE("all five rooms of the house and all cells of the maze are reached", "[slow]") {
  const Observable house = observable(load_world("house").value());
  for (const auto& [x, y] : {std::pair{-1.8, -3.0}, {3.0, -2.4}, {-3.2, 1.4}, {0.3, 1.4}, {3.4, 1.6}}) {
    CHECK(at(house, x, y) == SeenCell::free);
  }
  const World world = load_world("maze").value();
  const Observable maze = observable(world);
  for (int i = 0; i < 7; ++i) {
    for (int j = 0; j < 7; ++j) CHECK(at(maze, (i - 3) * 1.25, (j - 3) * 1.25) == SeenCell::free);
  }
}

TEST_CASE("the corridors close to loops", "[slow]") {
  const Observable loops = observable(load_world("loops").value());
  for (const auto& [x, y] : {std::pair{-6.3, 0.0},
                             {-3.9, 4.1},
                             {-3.9, -0.8},
                             {-3.9, -4.1},
                             {-1.2, 1.0},
                             {2.9, 4.0},
                             {2.9, -4.1},
                             {6.2, 0.0}}) {
    CHECK(at(loops, x, y) == SeenCell::free);
  }
  CHECK(at(loops, 2.9, 0.0) == SeenCell::not_observable);
}
