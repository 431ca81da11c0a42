// SPDX-License-Identifier: Apache-2.0
#include "nav/astar.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "nav/inflation.hpp"
#include "tests/support/floor_plans.hpp"
#include "tests/support/plain_planner.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::nav;
using Costs = CellGrid<std::uint8_t>;

namespace {

std::vector<Cell> as_vector(std::span<const Cell> cells) { return {cells.begin(), cells.end()}; }

Cell random_cell(tests::Random& random, const Costs& cost) {
  return {static_cast<int>(random.below(static_cast<std::uint32_t>(cost.columns))),
          static_cast<int>(random.below(static_cast<std::uint32_t>(cost.rows)))};
}

struct Tally {
  int found = 0;
  int unreachable = 0;
  int blocked = 0;
};

// Plans from random starts to random sets of goals, and compares with plain Dijkstra.
void compare(AStar& planner, const Costs& cost, std::uint64_t seed, int starts, const StepOptions& steps,
             Tally& tally) {
  tests::Random random(seed);
  for (int s = 0; s < starts; ++s) {
    const Cell start = random_cell(random, cost);
    const std::vector<std::uint32_t> truth = tests::plain_dijkstra(cost, start, steps);
    for (int k = 0; k < 6; ++k) {
      std::vector<Cell> goals;
      for (std::uint32_t n = k < 3 ? 1 : 1 + random.below(12); n > 0; --n) goals.push_back(random_cell(random, cost));
      std::uint32_t expected = tests::kNoWay;
      bool any_possible = false;
      for (const Cell& goal : goals) {
        const std::uint8_t c = cost.at(goal);
        const bool possible = c < 253 || (c == 255 && steps.allow_unknown) || goal == start;
        any_possible |= possible;
        if (possible) expected = std::min(expected, truth[cost.index(goal)]);
      }
      const PathResult result = planner.plan(cost, start, goals, {.steps = steps});
      if (!any_possible) {
        REQUIRE(result.status == PathStatus::goal_blocked);
        ++tally.blocked;
      } else if (expected == tests::kNoWay) {
        REQUIRE(result.status == PathStatus::unreachable);
        ++tally.unreachable;
      } else {
        REQUIRE(result.status == PathStatus::found);
        REQUIRE(result.cost == expected);
        REQUIRE(result.cells.front() == start);
        REQUIRE(std::find(goals.begin(), goals.end(), result.cells.back()) != goals.end());
        REQUIRE(tests::walked_cost(cost, as_vector(result.cells), steps) == expected);
        ++tally.found;
      }
    }
  }
}

}  // namespace

TEST_CASE("A* finds ways as cheap as Dijkstra's on random costs") {
  AStar planner(80 * 70);
  Tally tally;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Costs cost =
        tests::random_costs(seed, 10 + static_cast<int>(seed) * 3 % 70, 5 + static_cast<int>(seed) * 7 % 65);
    compare(planner, cost, seed, 3, {.allow_unknown = seed % 2 == 0}, tally);
  }
  CHECK(tally.found > 100);
  CHECK(tally.unreachable > 3);
  CHECK(tally.blocked > 3);
}

TEST_CASE("A* finds ways as cheap as Dijkstra's in inflated buildings") {
  AStar planner(1024 * 1024);
  Tally tally;
  const CellGrid<CellState> office = tests::office_floor(3, 300);
  Inflation inflation(office, {});
  inflation.rebuild(office);
  compare(planner, inflation.cost(), 5, 6, {}, tally);
  CHECK(tally.found > 3);
  for (const std::string& plan : tests::real_floor_plans()) {
    const auto floor = tests::mapped_floor(plan);
    REQUIRE(floor);
    if (floor->cells.size() > 1024 * 1024) continue;
    Inflation real(*floor, {});
    real.rebuild(*floor);
    compare(planner, real.cost(), 7, 2, {}, tally);
    compare(planner, real.cost(), 8, 1, {.allow_unknown = true}, tally);
  }
}

TEST_CASE("On free ground the path is straight, and found without detours") {
  Costs cost(0.05, 0, 0, 200, 100, kFreeCost);
  AStar planner(cost.cells.size());
  const std::array<Cell, 1> goal{Cell{150, 80}};
  const PathResult result = planner.plan(cost, {10, 20}, goal);
  REQUIRE(result.status == PathStatus::found);
  CHECK(result.cost == 80 * kStraightCost + 60 * kDiagonalCost);
  CHECK(result.cells.size() == 141);
  CHECK(result.expansions == 141);
}

TEST_CASE("Planning in portions gives the very same path") {
  const CellGrid<CellState> office = tests::office_floor(9, 400);
  Inflation inflation(office, {});
  inflation.rebuild(office);
  const Costs& cost = inflation.cost();
  AStar whole(cost.cells.size());
  AStar portions(cost.cells.size());
  const std::array<Cell, 2> goals{Cell{380, 20}, Cell{20, 300}};
  const PathResult expected = whole.plan(cost, {20, 20}, goals);
  REQUIRE(expected.status == PathStatus::found);
  REQUIRE(expected.expansions > 1000);
  PathResult result = portions.plan(cost, {20, 20}, goals, {.steps = {}, .max_expansions = 100});
  std::uint32_t expansions = result.expansions;
  while (result.status == PathStatus::budget_spent) {
    CHECK(result.cells.empty());
    result = portions.resume(cost, 333);
    REQUIRE(result.expansions <= 333);
    expansions += result.expansions;
  }
  REQUIRE(result.status == PathStatus::found);
  CHECK(expansions == expected.expansions);
  CHECK(as_vector(result.cells) == as_vector(expected.cells));
}

TEST_CASE("A robot that stands tight gets out, but never through an obstacle") {
  Costs cost(0.05, 0, 0, 60, 20, kInscribedCost);
  for (int y = 0; y < 20; ++y) {
    for (int x = 15; x < 60; ++x) cost.at({x, y}) = kFreeCost;
  }
  AStar planner(cost.cells.size());
  const std::array<Cell, 1> goal{Cell{40, 10}};
  CHECK(planner.plan(cost, {10, 10}, goal).status == PathStatus::found);       // 5 cells to the free ones
  CHECK(planner.plan(cost, {2, 10}, goal).status == PathStatus::unreachable);  // 13 cells
  for (int y = 0; y < 20; ++y) cost.at({13, y}) = kLethalCost;
  CHECK(planner.plan(cost, {10, 10}, goal).status == PathStatus::unreachable);
  const std::array<Cell, 1> back{Cell{10, 10}};
  CHECK(planner.plan(cost, {40, 10}, back).status == PathStatus::goal_blocked);  // relief is for starts alone
}

TEST_CASE("A goal in a closed room is given up without a look at the rest of the building") {
  Costs cost(0.05, 0, 0, 500, 500, kFreeCost);
  for (int i = 0; i <= 40; ++i) {
    for (const Cell c : {Cell{400 + i, 400}, Cell{400 + i, 440}, Cell{400, 400 + i}, Cell{440, 400 + i}}) {
      cost.at(c) = kLethalCost;
    }
  }
  AStar planner(cost.cells.size());
  const std::array<Cell, 2> goals{Cell{420, 420}, Cell{405, 430}};
  const PathResult inside = planner.plan(cost, {100, 100}, goals);
  CHECK(inside.status == PathStatus::unreachable);
  CHECK(inside.expansions < 39 * 39 + 10);
  const std::array<Cell, 3> one_outside{Cell{420, 420}, Cell{405, 430}, Cell{450, 450}};
  CHECK(planner.plan(cost, {100, 100}, one_outside).status == PathStatus::found);
  CHECK(planner.plan(cost, {420, 421}, goals).status == PathStatus::found);
  CHECK(planner.plan(cost, {420, 421}, std::array{Cell{100, 100}}).status == PathStatus::unreachable);
}

TEST_CASE("A planner says what is wrong with a question") {
  Costs cost(0.05, 0, 0, 10, 10, kFreeCost);
  AStar planner(cost.cells.size());
  const std::array<Cell, 1> goal{Cell{5, 5}};
  const std::array<Cell, 2> outside{Cell{-1, 5}, Cell{5, 10}};
  CHECK(planner.plan(cost, {10, 0}, goal).status == PathStatus::start_outside);
  CHECK(planner.plan(cost, {0, 0}, outside).status == PathStatus::goal_blocked);
  CHECK(planner.plan(cost, {0, 0}, {}).status == PathStatus::goal_blocked);
  const PathResult here = planner.plan(cost, {5, 5}, goal);
  CHECK(here.status == PathStatus::found);
  CHECK(here.cells.size() == 1);
  CHECK(here.cost == 0);
  CHECK(std::string(to_string(PathStatus::goal_blocked)) == "goal blocked");
}
