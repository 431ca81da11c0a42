// SPDX-License-Identifier: Apache-2.0
#include "nav/road_grid.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/support/flat_sim.hpp"
#include "tests/support/flat_world.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::nav;

namespace {

using Costs = CellGrid<std::uint8_t>;
constexpr std::int32_t kAll = TravelField::kNever - 100;

Costs two_rooms(int wall_cells) {
  tests::FlatWorld world;
  world.solid = Costs(0.05, 0.0, 0.0, 90, 40, 0);
  for (int y = 0; y < 40; ++y) {
    for (int x = 40; x < 40 + wall_cells; ++x) world.solid.at({x, y}) = 1;
  }
  return tests::true_costs(world.solid);
}

}  // namespace

TEST_CASE("no road leads through a wall of one cell") {
  for (int shift = 0; shift < 6; ++shift) {
    Costs costs(0.05, 0.0, 0.0, 90, 40, 0);
    const Costs walled = two_rooms(1);
    for (int y = 0; y < 40; ++y) {
      for (int x = shift; x < 90; ++x) costs.at({x, y}) = walled.at({x - shift, y});
    }
    RoadGrid roads;
    roads.reset(costs, 0.18);
    TravelField field;
    roads.size_field(field);
    roads.travel(roads.road_of({10, 20}), kAll, field);
    CHECK(field.distance[roads.road_of({20, 10})] != TravelField::kNever);
    CHECK(field.distance[roads.road_of({70, 20})] == TravelField::kNever);
  }
}

TEST_CASE("distances are those of the shortest ways, and a limit cuts them off") {
  const Costs costs = tests::true_costs(tests::make_flat_world("maze", 3).solid);
  RoadGrid roads;
  roads.reset(costs, 0.18);
  std::uint32_t from = 0;
  while (!roads.is_open(from)) ++from;
  TravelField field;
  roads.size_field(field);
  roads.travel(from, kAll, field);
  // Bellman and Ford: relax until nothing changes.
  std::vector<std::int64_t> plain(roads.size(), 1'000'000'000);
  plain[from] = 0;
  for (bool changed = true; changed;) {
    changed = false;
    for (int y = 0; y < roads.rows(); ++y) {
      for (int x = 0; x < roads.columns(); ++x) {
        const std::size_t at = static_cast<std::size_t>(y * roads.columns() + x);
        if (!roads.is_open(at)) continue;
        for (int k = 0; k < 9; ++k) {
          const int nx = x + k % 3 - 1;
          const int ny = y + k / 3 - 1;
          if (nx < 0 || ny < 0 || nx >= roads.columns() || ny >= roads.rows()) continue;
          const std::size_t n = static_cast<std::size_t>(ny * roads.columns() + nx);
          const std::int64_t there = plain[n] + (nx != x && ny != y ? 14 : 10);
          if ((roads.is_open(n) || n == from) && there < plain[at]) {
            plain[at] = there;
            changed = true;
          }
        }
      }
    }
  }
  std::size_t reached = 0;
  for (std::size_t i = 0; i < roads.size(); ++i) {
    const bool never = field.distance[i] == TravelField::kNever;
    REQUIRE(never == (plain[i] == 1'000'000'000));
    if (!never) REQUIRE(field.distance[i] == plain[i]);
    reached += !never;
  }
  CHECK(field.reached.size() == reached);

  roads.travel(from, 100, field);
  for (std::size_t i = 0; i < roads.size(); ++i) {
    REQUIRE((field.distance[i] != TravelField::kNever) == (plain[i] <= 100));
  }
}

TEST_CASE("roads kept from changes equal those of a fresh look") {
  tests::Random random(9);
  Costs costs(0.05, 0.0, 0.0, 50, 41, kUnknownCost);
  RoadGrid kept;
  kept.reset(costs, 0.18);
  for (int step = 0; step < 100; ++step) {
    std::vector<std::uint32_t> changed;
    for (int n = 0; n < 20; ++n) {
      const std::uint32_t i = random.below(static_cast<std::uint32_t>(costs.cells.size()));
      costs.cells[i] = static_cast<std::uint8_t>(random.below(256));
      changed.push_back(i);
    }
    kept.update(costs, changed);
    RoadGrid fresh;
    fresh.reset(costs, 0.18);
    for (std::size_t i = 0; i < kept.size(); ++i) REQUIRE(kept.is_open(i) == fresh.is_open(i));
  }
}

TEST_CASE("ways say by which heading they leave and arrive") {
  Costs costs(0.05, 0.0, 0.0, 60, 60, kLethalCost);
  for (int i = 6; i < 51; ++i) {
    for (int w = 0; w < 6; ++w) {
      costs.at({i, 6 + w}) = 0;
      costs.at({45 + w, i}) = 0;
    }
  }
  RoadGrid roads;
  roads.reset(costs, 0.18);
  TravelField field;
  roads.size_field(field);
  const std::uint32_t from = roads.road_of({7, 9});
  const std::uint32_t to = roads.road_of({48, 49});
  roads.travel(from, kAll, field);
  CHECK(std::abs(roads.leave_heading(field, from, to)) < 0.4);
  CHECK(std::abs(roads.arrive_heading(field, to) - 1.5708) < 0.4);
  Cell best;
  REQUIRE(roads.best_cell(costs, from, best));
  CHECK(costs.at(best) == 0);
  CHECK_FALSE(roads.best_cell(costs, roads.road_of({30, 40}), best));
}

TEST_CASE("a robot that stands too near to something gets out again, but not through the wall") {
  Costs costs(0.05, 0.0, 0.0, 90, 40, 0);
  const Costs walled = two_rooms(1);
  for (int y = 0; y < 40; ++y) {
    for (int x = 1; x < 90; ++x) costs.at({x, y}) = walled.at({x - 1, y});
  }
  RoadGrid roads;
  roads.reset(costs, 0.18);
  TravelField field;
  roads.size_field(field);
  const std::uint32_t from = roads.road_of({39, 20});  // 10 cm before the wall
  REQUIRE_FALSE(roads.is_open(from));
  roads.travel(from, kAll, field);
  CHECK(field.reached.front() == from);
  CHECK(field.distance[roads.road_of({36, 20})] == 10);
  CHECK(field.distance[roads.road_of({10, 20})] != TravelField::kNever);
  CHECK(field.distance[roads.road_of({70, 20})] == TravelField::kNever);
}
