// SPDX-License-Identifier: Apache-2.0
#include "nav/explain.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using namespace g3d::nav;

namespace {

/// Solid but for a few free pockets with an unknown cell at their end.
struct Site {
  Site() : ground(0.05, 0.0, 0.0, 120, 40, CellState::occupied) {
    for (int x = 10; x < 40; ++x) ground.at({x, 20}) = CellState::free;  // a slit of 1.5 m
    ground.at({9, 20}) = CellState::unknown;
    ground.at({80, 20}) = CellState::free;  // a hole of one cell
    ground.at({81, 20}) = CellState::unknown;
    frontiers.reset(ground);
    frontiers.make_clusters();
    targets.reset(120, 40);
    aside.reset(targets.size(), 2, 30.0);
    roads.reset(CellGrid<std::uint8_t>(0.05, 0.0, 0.0, 120, 40, kLethalCost), 0.18);
    places.reset(ground, roads);
    explanation.reset(targets.size());
    slit = targets.of_cell(static_cast<std::uint32_t>(ground.index({10, 20})));
    hole = targets.of_cell(static_cast<std::uint32_t>(ground.index({80, 20})));
  }
  FrontiersLeft left(bool any_open) {
    return explanation.explain(ground, frontiers, targets, aside, places, 0.8, any_open);
  }
  CellGrid<CellState> ground;
  FrontierMap frontiers;
  Targets targets;
  SetAside aside;
  RoadGrid roads;
  Viewpoints places;
  Explanation explanation;
  std::uint32_t slit = 0;
  std::uint32_t hole = 0;
};

}  // namespace

TEST_CASE("nobody gets there: unreachable if there is room to look from, else out of sight") {
  Site site;
  const FrontiersLeft left = site.left(false);
  CHECK(left[LeftReason::unreachable] == 1);
  CHECK(left[LeftReason::out_of_sight] == 1);
  CHECK(left.open == 0);
}

TEST_CASE("what failed often enough says how it failed, and what is outside says so first") {
  Site site;
  for (int i = 0; i < 2; ++i) {
    site.aside.target_failed(site.slit, SetAside::Cause::fruitless, 0);
    site.aside.target_failed(site.hole, SetAside::Cause::blocked, 0);
    site.aside.wake_all();
  }
  FrontiersLeft left = site.left(false);
  CHECK(left[LeftReason::fruitless] == 1);
  CHECK(left[LeftReason::blocked] == 1);
  site.aside.exclude(site.slit);
  left = site.left(false);
  CHECK(left[LeftReason::outside_area] == 1);
  CHECK(left[LeftReason::fruitless] == 0);
}

TEST_CASE("every cluster is counted once, seen ones as open or too small") {
  CellGrid<CellState> ground(0.05, 0.0, 0.0, 80, 80, CellState::free);
  for (int y = 30; y < 50; ++y) ground.at({70, y}) = CellState::unknown;
  const CellGrid<std::uint8_t> cost(0.05, 0.0, 0.0, 80, 80, 0);
  FrontierMap frontiers;
  frontiers.reset(ground);
  frontiers.make_clusters();
  RoadGrid roads;
  roads.reset(cost, 0.18);
  TravelField field;
  roads.size_field(field);
  roads.travel(roads.road_of({20, 40}), TravelField::kNever - 100, field);
  Viewpoints places;
  places.reset(ground, roads);
  REQUIRE(places.refresh(ground, cost, roads, field, frontiers, ViewGain(ViewModel{}, 0.05), 100000));
  Targets targets;
  targets.reset(80, 80);
  SetAside aside;
  aside.reset(targets.size(), 3, 30.0);
  Explanation explanation;
  explanation.reset(targets.size());
  CHECK(explanation.explain(ground, frontiers, targets, aside, places, 0.8, true).open == frontiers.clusters().size());
  const FrontiersLeft left = explanation.explain(ground, frontiers, targets, aside, places, 0.8, false);
  CHECK(left[LeftReason::too_small] == frontiers.clusters().size());
  CHECK(left.open == 0);
}
