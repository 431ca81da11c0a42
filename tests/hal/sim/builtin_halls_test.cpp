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

TEST_CASE("every aisle of the warehouse can be driven and its racks be seen", "[slow]") {
  const Observable all = observable(load_world("warehouse").value());
  for (const double y : {-4.2, -1.6, 1.0, 3.6}) CHECK(at(all, -3.7, y) == SeenCell::free);
  CHECK(all.free_count > 50'000);
  CHECK(all.wall_count > 2'000);
}

TEST_CASE("from the middle of the hall no wall is in range", "[slow]") {
  const World world = load_world("hall").value();
  const Observable all = observable(world);
  const PlanarPose& start = world.starts()[0];
  for (std::size_t i = 0; i < all.cells.size(); ++i) {
    if (all.cells[i] != SeenCell::wall) continue;
    const double x = all.frame.x_m(static_cast<int>(i % static_cast<std::size_t>(all.frame.columns))) - start.x_m;
    const double y = all.frame.y_m(static_cast<int>(i / static_cast<std::size_t>(all.frame.columns))) - start.y_m;
    REQUIRE(x * x + y * y > 3.5 * 3.5);
  }
}

TEST_CASE("people of the lobby walk rounds and through no furniture") {
  const World world = load_world("people").value();
  REQUIRE(world.movers().size() == 3);
  const FloorContact floor(world);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& points = world.movers()[i].waypoints;
    CHECK(points.front().x_m == points.back().x_m);
    CHECK(points.front().y_m == points.back().y_m);
    for (TimeNs t = 0; t < static_cast<TimeNs>(points.back().t_s * 1e9); t += 100'000'000) {
      const auto place = world.mover_at(i, t);
      CAPTURE(i, t, place[0], place[1]);
      const auto thing = floor.nearest(double{place[0]}, double{place[1]}, {0.02, 1.8}, {}, -1);
      REQUIRE((thing.kind == FloorContact::Kind::nothing || thing.at.distance_m > 0.25));
    }
  }
}
