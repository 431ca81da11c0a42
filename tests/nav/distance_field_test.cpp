// SPDX-License-Identifier: Apache-2.0
#include "nav/distance_field.hpp"

#include <catch2/catch.hpp>

#include "mapper/cuda/ask_grid.hpp"
#include "nav/astar.hpp"
#include "nav/inflation.hpp"
#include "tests/support/floor_plans.hpp"
#include "tests/support/plain_planner.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/small_card.hpp"

using namespace g3d;
using namespace g3d::nav;
using Costs = CellGrid<std::uint8_t>;

namespace {

void compare(DistanceField& field, const Costs& cost, Cell start, const StepOptions& steps) {
  const std::vector<std::uint32_t> truth = tests::plain_dijkstra(cost, start, steps);
  field.compute(cost, start, {.steps = steps});
  std::size_t reached = 0;
  std::size_t wrong = 0;
  for (std::uint32_t i = 0; i < truth.size(); ++i) {
    wrong += field.cost_to(i) != truth[i] ? 1 : 0;
    reached += truth[i] != tests::kNoWay ? 1 : 0;
  }
  REQUIRE(wrong == 0);
  REQUIRE(field.reached().size() == reached);
  std::uint32_t last = 0;
  for (const std::uint32_t index : field.reached()) {
    REQUIRE(field.cost_to(index) >= last);
    last = field.cost_to(index);
  }
}

}  // namespace

TEST_CASE("Travel costs are Dijkstra's in every cell") {
  DistanceField field(600 * 600);
  tests::Random random(4);
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const Costs cost =
        tests::random_costs(seed, 5 + static_cast<int>(random.below(70)), 5 + static_cast<int>(random.below(70)));
    const Cell start{static_cast<int>(random.below(static_cast<std::uint32_t>(cost.columns))),
                     static_cast<int>(random.below(static_cast<std::uint32_t>(cost.rows)))};
    compare(field, cost, start, {.allow_unknown = seed % 3 == 0, .relief_cells = static_cast<int>(seed % 5)});
  }
  const CellGrid<CellState> office = tests::office_floor(2, 400);
  Inflation inflation(office, {});
  inflation.rebuild(office);
  compare(field, inflation.cost(), {100, 20}, {});
}

TEST_CASE("a card in random order finds Dijkstra's travel costs", "[cuda]") {
  DistanceField field(160 * 160);
  tests::Random random(14);
  mapper::cuda::Emulated card = test::small_card(160 * 160, 3);
  std::size_t reached = 0;
  const auto check = [&](const Costs& cost, Cell start, const DistanceOptions& options) {
    field.compute(cost, start, options);
    std::vector<std::uint32_t> distances(cost.cells.size());
    REQUIRE(mapper::cuda::ask_grid(card, spread_of(cost, start, options), cost.cells, distances));
    std::size_t different = 0;
    for (std::uint32_t i = 0; i < distances.size(); ++i) different += distances[i] != field.cost_to(i) ? 1 : 0;
    CHECK(different == 0);
    reached += field.reached().size();
  };
  for (std::uint64_t seed = 1; seed <= 25; ++seed) {
    const Costs cost =
        tests::random_costs(seed, 1 + static_cast<int>(random.below(120)), 1 + static_cast<int>(random.below(120)));
    const Cell start{static_cast<int>(random.below(static_cast<std::uint32_t>(cost.columns))),
                     static_cast<int>(random.below(static_cast<std::uint32_t>(cost.rows)))};
    check(cost, start,
          {.steps = {.allow_unknown = seed % 3 == 0, .relief_cells = static_cast<int>(seed % 5)},
           .max_cost = seed % 4 == 0 ? 900U : SearchLabels::kRange});
  }
  // A way that winds through every tile many times.
  Costs maze(0.05, 0, 0, 100, 70, kFreeCost);
  for (int y = 2; y < 70; y += 4) {
    for (int x = 0; x < 99; ++x) maze.at({y % 8 == 2 ? x : 99 - x, y}) = kLethalCost;
  }
  check(maze, {0, 0}, {});
  CHECK(reached > 20000);
}

TEST_CASE("The way to a reached cell costs what the field says, and what A* says") {
  const CellGrid<CellState> office = tests::office_floor(8, 350);
  Inflation inflation(office, {});
  inflation.rebuild(office);
  const Costs& cost = inflation.cost();
  DistanceField field(cost.cells.size());
  AStar planner(cost.cells.size());
  const Cell start{60, 22};
  field.compute(cost, start);
  REQUIRE(field.reached().size() > 5000);
  std::vector<Cell> path;
  for (std::size_t i = 0; i < field.reached().size(); i += 2000) {
    const Cell goal = cost.cell(field.reached()[i]);
    REQUIRE(field.path_to(goal, path));
    CHECK(path.front() == start);
    CHECK(path.back() == goal);
    CHECK(tests::walked_cost(cost, path, {}) == field.cost_to(goal));
    CHECK(planner.plan(cost, start, {&goal, 1}).cost == field.cost_to(goal));
  }
}

TEST_CASE("A field ends where it was told to, and forgets the one before") {
  Costs cost(0.05, 0, 0, 100, 100, kFreeCost);
  DistanceField field(cost.cells.size());
  field.compute(cost, {50, 50});
  CHECK(field.reached().size() == 10000);
  field.compute(cost, {10, 10}, {.steps = {}, .max_cost = 10 * kStraightCost});
  CHECK(field.cost_to(Cell{20, 10}) == 10 * kStraightCost);
  CHECK(field.cost_to(Cell{21, 10}) == DistanceField::kUnreached);
  CHECK(field.cost_to(Cell{90, 90}) == DistanceField::kUnreached);
  CHECK(field.cost_to(Cell{-1, 10}) == DistanceField::kUnreached);
  std::vector<Cell> path;
  CHECK_FALSE(field.path_to({90, 90}, path));
  field.compute(cost, {100, 10});  // outside
  CHECK(field.reached().empty());
  CHECK(field.cost_to(Cell{10, 10}) == DistanceField::kUnreached);
}
