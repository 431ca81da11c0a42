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

TEST_CASE("between the clutter of the laboratory there is a way to nearly everywhere", "[slow]") {
  const Observable all = observable(load_world("lab").value());
  CHECK(static_cast<double>(all.reachable_count) > 0.6 * static_cast<double>(all.free_count));
  CHECK(at(all, -3.0, -2.5) == SeenCell::free);
  CHECK(at(all, 2.4, 2.2) == SeenCell::free);
}

TEST_CASE("the glass offices hide black furniture and show what is behind panes", "[slow]") {
  const World world = load_world("glass").value();
  const Observable all = observable(world);
  CHECK(at(all, 2.3, 2.6) == SeenCell::free);
  CHECK(at(all, 4.12, -2.2) == SeenCell::not_observable);  // front of the black sofa
  CHECK(at(all, -1.6, -2.0) == SeenCell::wall);            // the frame of a pane
  CHECK(at(all, -3.4, 1.6) == SeenCell::free);             // a pane without frame: nobody can see it
  const FloorContact floor(world);
  CHECK(floor.nearest(-3.4, 1.4, {0.05, 0.11}, {}, -1).at.distance_m < 0.2);
}
