// SPDX-License-Identifier: Apache-2.0
#include "nav/viewpoints.hpp"

#include <catch2/catch.hpp>
#include <map>

#include "tests/support/flat_sim.hpp"

using namespace g3d;
using namespace g3d::nav;

namespace {

/// Everything that refresh() needs, kept up to date with a sim.
struct Fixture {
  explicit Fixture(const tests::FlatSim& sim) : camera(ViewModel{}, sim.ground().resolution_m) {
    frontiers.reset(sim.ground());
    roads.reset(sim.cost(), 0.18);
    roads.size_field(field);
    places.reset(sim.ground(), roads);
  }
  bool refresh(const tests::FlatSim& sim, std::span<const std::uint32_t> changed, int budget) {
    frontiers.update(sim.ground(), changed);
    roads.update(sim.cost(), changed);
    places.note_changes(changed);
    roads.travel(roads.road_of(sim.ground().cell_of(sim.pose().x_m, sim.pose().y_m)), TravelField::kNever - 100, field);
    return places.refresh(sim.ground(), sim.cost(), roads, field, frontiers, camera, budget);
  }
  ViewGain camera;
  FrontierMap frontiers;
  RoadGrid roads;
  TravelField field;
  Viewpoints places;
};

}  // namespace

TEST_CASE("places kept from changes show what freshly cast ones show") {
  const tests::FlatWorld world = tests::make_flat_world("house", 2);
  tests::FlatSim sim(world, tests::choose_start(world, 2));
  Fixture kept(sim);
  for (int step = 0; step < 60; ++step) {
    for (int i = 0; i < 5; ++i) sim.step(0.3, step % 7 < 3 ? 0.9 : -0.2);
    const auto changed = sim.take_changed();
    REQUIRE(kept.refresh(sim, changed, 100000));
    Fixture fresh(sim);
    REQUIRE(fresh.refresh(sim, {}, 100000));
    REQUIRE(kept.places.useful().size() == fresh.places.useful().size());
    for (std::size_t k = 0; k < kept.places.useful().size(); ++k) {
      const Place& a = kept.places.place(kept.places.useful()[k]);
      const Place& b = fresh.places.place(fresh.places.useful()[k]);
      REQUIRE(a.cell == b.cell);
      REQUIRE(a.total_cells == b.total_cells);
    }
  }
  CHECK(kept.places.useful().size() > 5);
}

TEST_CASE("the body may stand at every place, and the way there exists") {
  const tests::FlatWorld world = tests::make_flat_world("lab", 1);
  tests::FlatSim sim(world, tests::choose_start(world, 1));
  for (int i = 0; i < 63; ++i) sim.step(0.0, 1.0);
  Fixture f(sim);
  REQUIRE(f.refresh(sim, {}, 100000));
  REQUIRE_FALSE(f.places.useful().empty());
  std::int32_t last = 0;
  for (const std::uint32_t slot : f.places.useful()) {
    const Place& place = f.places.place(slot);
    CHECK(sim.cost().at(place.cell) < kInscribedCost);
    CHECK(f.field.distance[place.road] != TravelField::kNever);
    CHECK(f.field.distance[place.road] + 30 >= last);
    last = f.field.distance[place.road];
  }
}

TEST_CASE("work beyond the budget is done in the calls that follow") {
  const tests::FlatWorld world = tests::make_flat_world("hall", 1);
  tests::FlatSim sim(world, tests::choose_start(world, 1));
  for (int i = 0; i < 63; ++i) sim.step(0.0, 1.0);
  Fixture f(sim);
  int calls = 1;
  while (!f.refresh(sim, {}, 10)) ++calls;
  CHECK(calls > 1);
  Fixture all(sim);
  REQUIRE(all.refresh(sim, {}, 100000));
  CHECK(f.places.useful().size() == all.places.useful().size());
}
