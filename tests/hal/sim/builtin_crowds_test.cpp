// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "hal/sim/load_world.hpp"
#include "hal/sim/observable.hpp"

using namespace g3d::hal;

TEST_CASE("people in crowds walk rounds, through no wall, at a walking pace") {
  for (const char* name : {"passage", "crossings", "crowd"}) {
    const World world = load_world(name).value();
    CHECK(world.movers().size() >= 3);
    const FloorContact floor(world);
    for (std::size_t i = 0; i < world.movers().size(); ++i) {
      const auto& points = world.movers()[i].waypoints;
      CHECK(points.front().x_m == points.back().x_m);
      CHECK(points.front().y_m == points.back().y_m);
      auto before = world.mover_at(i, 0);
      for (TimeNs t = 100'000'000; t < static_cast<TimeNs>(points.back().t_s * 1e9); t += 100'000'000) {
        const auto place = world.mover_at(i, t);
        CAPTURE(name, i, t, place[0], place[1]);
        const auto thing = floor.nearest(double{place[0]}, double{place[1]}, {0.02, 1.8}, {}, -1);
        REQUIRE((thing.kind == FloorContact::Kind::nothing || thing.at.distance_m > 0.25));
        REQUIRE(std::hypot(double{place[0]} - double{before[0]}, double{place[1]} - double{before[1]}) < 0.15);
        before = place;
      }
    }
  }
}

TEST_CASE("a robot and a person fit past each other in the passage, and its chambers can be seen", "[slow]") {
  const World world = load_world("passage").value();
  const Observable all = find_observable(world, std::span(world.starts()).first(1)).value();
  const auto at = [&](double x_m, double y_m) {
    return all.cells[all.frame.index(all.frame.column_of(x_m), all.frame.row_of(y_m))];
  };
  for (const double x : {-3.0, 3.0}) CHECK(at(x, 2.0) == SeenCell::free);
  CHECK(at(3.5, -2.0) == SeenCell::free);
  CHECK(at(0.0, 0.8) == SeenCell::free);
  CHECK(at(0.0, 0.92) == SeenCell::wall);
}
