// SPDX-License-Identifier: Apache-2.0
#include "nav/tour_search.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/flat_sim.hpp"

using namespace g3d;
using namespace g3d::nav;

namespace {

struct Scene {
  explicit Scene(const char* name)
      : world(tests::make_flat_world(name, 1)), start(tests::choose_start(world, 1)), sim(world, start) {
    for (int i = 0; i < 63; ++i) sim.step(0.0, 1.0);
    search.reset(sim.ground(), sim.cost(), SearchConfig{});
    aside.reset(search.targets().size(), 3, 30.0);
  }
  void begin() {
    const Cell at = sim.ground().cell_of(sim.pose().x_m, sim.pose().y_m);
    search.begin(at, sim.pose(), std::nullopt, [](const Place&) { return true; });
  }
  /// How many pieces it took.
  int finish(std::int64_t units) {
    for (int pieces = 1; pieces < 10'000'000; ++pieces) {
      WorkBudget budget(units);
      if (search.go_on(sim.ground(), sim.cost(), aside, budget)) return pieces;
    }
    return -1;
  }
  tests::FlatWorld world;
  hal::PlanarPose start;
  tests::FlatSim sim;
  TourSearch search;
  SetAside aside;
};

}  // namespace

TEST_CASE("After a look around there are views to take, each with a way, and frontiers that are open") {
  Scene scene("house");
  scene.begin();
  CHECK(scene.finish(std::numeric_limits<std::int64_t>::max()) == 1);
  REQUIRE_FALSE(scene.search.views().empty());
  for (const View& view : scene.search.views()) CHECK(scene.search.way_m(view.road));
  CHECK(scene.search.left().open > 0);
  CHECK(scene.search.frontiers().cells().size() > 20);
}

TEST_CASE("A search that is dropped half way leaves nothing behind") {
  Scene dropped("house");
  Scene fresh("house");
  for (const int pieces : {1, 30, 300, 3000}) {
    dropped.begin();
    for (int i = 0; i < pieces; ++i) {
      WorkBudget budget(3);
      if (dropped.search.go_on(dropped.sim.ground(), dropped.sim.cost(), dropped.aside, budget)) break;
    }
  }
  dropped.begin();
  fresh.begin();
  CHECK(dropped.finish(7) > 10);
  CHECK(fresh.finish(100'000) > 0);
  REQUIRE(dropped.search.views().size() == fresh.search.views().size());
  for (std::size_t i = 0; i < fresh.search.views().size(); ++i) {
    CHECK(dropped.search.views()[i].road == fresh.search.views()[i].road);
    CHECK(dropped.search.views()[i].heading_rad == fresh.search.views()[i].heading_rad);
  }
  CHECK(dropped.search.left() == fresh.search.left());
}

TEST_CASE("The map may change between pieces: the next search knows all of it") {
  Scene scene("house");
  Scene fresh("house");
  scene.begin();
  (void)scene.sim.take_changed();
  (void)fresh.sim.take_changed();
  for (int i = 0; i < 200; ++i) {
    WorkBudget budget(500);
    (void)scene.search.go_on(scene.sim.ground(), scene.sim.cost(), scene.aside, budget);
    if (i % 10 != 0) continue;
    scene.sim.step(0.3, 0.2);
    fresh.sim.step(0.3, 0.2);
    scene.search.take_changes(scene.sim.ground(), scene.sim.cost(), scene.sim.take_changed());
  }
  fresh.search.reset(fresh.sim.ground(), fresh.sim.cost(), SearchConfig{});
  scene.begin();
  fresh.begin();
  (void)scene.finish(1000);
  (void)fresh.finish(1000);
  REQUIRE(scene.search.views().size() == fresh.search.views().size());
  for (std::size_t i = 0; i < fresh.search.views().size(); ++i) {
    CHECK(scene.search.views()[i].road == fresh.search.views()[i].road);
    CHECK(scene.search.views()[i].heading_rad == fresh.search.views()[i].heading_rad);
  }
}
