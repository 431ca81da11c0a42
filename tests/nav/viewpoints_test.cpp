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

TEST_CASE("what one cell alone sees through a slit is found by looking closer, and by nothing else") {
  CellGrid<CellState> ground(0.05, 0.0, 0.0, 100, 100, CellState::unknown);
  CellGrid<std::uint8_t> cost(0.05, 0.0, 0.0, 100, 100, 0);
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 100; ++x) {
      const bool is_wall = x < 20 || x >= 80 || y < 10 || y >= 50;
      const bool is_slit = x == 50 && y >= 50 && y < 79;
      const bool is_room = y >= 79 && x >= 30 && x < 70;
      if (!is_room) ground.at({x, y}) = is_wall && !is_slit ? CellState::occupied : CellState::free;
      cost.at({x, y}) = is_wall ? kLethalCost : std::uint8_t{0};
    }
  }
  ViewGain camera(ViewModel{}, 0.05);
  FrontierMap frontiers;
  RoadGrid roads;
  TravelField field;
  Viewpoints places;
  frontiers.reset(ground);
  roads.reset(cost, 0.18);
  roads.size_field(field);
  places.reset(ground, roads);
  roads.travel(roads.road_of({50, 30}), TravelField::kNever - 100, field);
  const auto most_cells = [&] {
    REQUIRE(places.refresh(ground, cost, roads, field, frontiers, camera, 100000));
    float most = 0.0F;
    for (const std::uint32_t slot : places.useful()) most = std::max(most, places.place(slot).total_cells);
    return most;
  };
  const float from_cheapest = most_cells();
  places.look_closer(true);
  const float from_any = most_cells();
  CAPTURE(from_cheapest, from_any);
  CHECK(from_cheapest < 12.0F);
  CHECK(from_any > 3.0F * from_cheapest);
  places.look_closer(false);
  CHECK(most_cells() == from_any);  // known until the map changes there
  const std::uint32_t changed[] = {static_cast<std::uint32_t>(ground.index({50, 49}))};
  places.note_changes(changed);
  CHECK(most_cells() == from_cheapest);
}
