// SPDX-License-Identifier: Apache-2.0
#include "nav/path_smoothing.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "nav/astar.hpp"
#include "nav/inflation.hpp"
#include "tests/support/floor_plans.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::nav;
using Costs = CellGrid<std::uint8_t>;

namespace {

double length_m(std::span<const Waypoint> points) {
  double sum_m = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    sum_m += std::hypot(points[i].x_m - points[i - 1].x_m, points[i].y_m - points[i - 1].y_m);
  }
  return sum_m;
}

double length_m(const Costs& cost, std::span<const Cell> path) {
  double sum_cells = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    sum_cells += std::hypot(path[i].x - path[i - 1].x, path[i].y - path[i - 1].y);
  }
  return sum_cells * cost.resolution_m;
}

// The costliest cell at any of many points of a straight stretch.
std::uint8_t sampled_costliest(const Costs& cost, Waypoint a, Waypoint b) {
  std::uint8_t costliest = 0;
  for (int i = 0; i <= 1000; ++i) {
    const double t = i / 1000.0;
    const Cell c = cost.cell_of(a.x_m + t * (b.x_m - a.x_m), a.y_m + t * (b.y_m - a.y_m));
    costliest = std::max(costliest, cost.at(c));
  }
  return costliest;
}

}  // namespace

TEST_CASE("A line's costliest cell is the one that samples along it find") {
  tests::Random random(5);
  const Costs cost = tests::random_costs(3, 80, 60);
  int equal = 0;
  for (int i = 0; i < 400; ++i) {
    const Cell a{static_cast<int>(random.below(80)), static_cast<int>(random.below(60))};
    const Cell b{static_cast<int>(random.below(80)), static_cast<int>(random.below(60))};
    const LineCost line = cost_of_line(cost, a, b, kUnknownCost);
    // The line's first cell is where one stands already.
    const std::uint8_t whole = std::max(line.costliest, cost.at(a));
    const std::uint8_t sampled =
        sampled_costliest(cost, {cost.centre_x_m(a), cost.centre_y_m(a)}, {cost.centre_x_m(b), cost.centre_y_m(b)});
    REQUIRE(whole >= sampled);  // samples may miss a cell that is cut at its corner
    equal += whole == sampled ? 1 : 0;
    REQUIRE(cost_of_line(cost, a, b, 7).costliest == [&] {
      Costs known = cost;
      for (std::uint8_t& value : known.cells) value = value == kUnknownCost ? 7 : value;
      return cost_of_line(known, a, b, 99).costliest;
    }());
  }
  CHECK(equal > 300);
  CHECK(cost_of_line(cost, {0, 0}, {80, 3}, 0).costliest == kUnknownCost);
}

TEST_CASE("A line that touches a corner touches both cells beside it") {
  Costs cost(0.05, 0, 0, 10, 10, kFreeCost);
  cost.at({4, 3}) = kLethalCost;
  CHECK(cost_of_line(cost, {2, 2}, {6, 6}, 0).costliest == kLethalCost);
  CHECK(cost_of_line(cost, {6, 6}, {2, 2}, 0).costliest == kLethalCost);
  CHECK(cost_of_line(cost, {2, 3}, {6, 7}, 0).costliest == kFreeCost);
  CHECK(cost_of_line(cost, {0, 0}, {3, 4}, 0).total == Approx(5.0 * kStraightCost));
}

TEST_CASE("Smoothed paths are shorter, never cost more clearance, and begin and end where they should") {
  const CellGrid<CellState> office = tests::office_floor(4, 400);
  Inflation inflation(office, {});
  inflation.rebuild(office);
  const Costs& cost = inflation.cost();
  AStar planner(cost.cells.size());
  PathSmoother smoother;
  const SmoothingOptions options;
  tests::Random random(1);
  int smoothed = 0;
  double shorter_m = 0.0;
  for (int i = 0; i < 60; ++i) {
    const Cell start{static_cast<int>(random.below(400)), static_cast<int>(random.below(400))};
    const Cell goal{static_cast<int>(random.below(400)), static_cast<int>(random.below(400))};
    if (cost.at(start) >= kInscribedCost) continue;
    const PathResult path = planner.plan(cost, start, {&goal, 1});
    if (path.status != PathStatus::found) continue;
    const std::span<const Waypoint> points = smoother.smooth(cost, path.cells, options);
    REQUIRE(points.front() == Waypoint{cost.centre_x_m(start), cost.centre_y_m(start)});
    REQUIRE(points.back() == Waypoint{cost.centre_x_m(goal), cost.centre_y_m(goal)});
    REQUIRE(length_m(points) <= length_m(cost, path.cells) + 1e-9);
    shorter_m += length_m(cost, path.cells) - length_m(points);
    for (std::size_t k = 1; k < points.size(); ++k) {
      REQUIRE(std::hypot(points[k].x_m - points[k - 1].x_m, points[k].y_m - points[k - 1].y_m) <= 0.05 + 1e-6);
    }
    const std::span<const std::uint32_t> corners = smoother.corners();
    REQUIRE(corners.back() + 1 == path.cells.size());
    for (std::size_t k = 1; k < corners.size(); ++k) {
      if (corners[k] == corners[k - 1] + 1) continue;  // the planner's own step
      std::uint8_t allowed = options.always_fine_cost;
      for (std::size_t n = corners[k - 1]; n <= corners[k]; ++n) allowed = std::max(allowed, cost.at(path.cells[n]));
      const Cell a = path.cells[corners[k - 1]];
      const Cell b = path.cells[corners[k]];
      REQUIRE(sampled_costliest(cost, {cost.centre_x_m(a), cost.centre_y_m(a)},
                                {cost.centre_x_m(b), cost.centre_y_m(b)}) <= allowed);
    }
    CHECK(corners.size() < path.cells.size() / 2 + 3);
    ++smoothed;
  }
  CHECK(smoothed > 15);
  CHECK(shorter_m > 1.0);
}

TEST_CASE("Across an open hall the path is one straight line with points at equal distances") {
  Costs cost(0.05, 1.0, 2.0, 100, 100, kFreeCost);
  AStar planner(cost.cells.size());
  PathSmoother smoother;
  const std::array<Cell, 1> goal{Cell{80, 40}};
  const PathResult path = planner.plan(cost, {10, 10}, goal);
  const std::span<const Waypoint> points = smoother.smooth(cost, path.cells, {});
  CHECK(smoother.corners().size() == 2);
  const double whole_m = std::hypot(70, 30) * 0.05;
  CHECK(length_m(points) == Approx(whole_m));
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double step_m = std::hypot(points[i].x_m - points[i - 1].x_m, points[i].y_m - points[i - 1].y_m);
    REQUIRE(step_m == Approx(whole_m / static_cast<double>(points.size() - 1)));
  }
  CHECK(smoother.smooth(cost, path.cells, {.spacing_m = 0.0}).size() == 2);
}

TEST_CASE("A narrow door does not make the rest of the way hug the wall") {
  CellGrid<CellState> floor(0.05, 0, 0, 200, 120, CellState::free);
  for (int y = 0; y < 120; ++y) floor.at({150, y}) = y >= 20 && y < 29 ? CellState::free : CellState::occupied;
  for (int x = 0; x < 150; ++x) floor.at({x, 10}) = CellState::occupied;
  Inflation inflation(floor, {});
  inflation.rebuild(floor);
  const Costs& cost = inflation.cost();
  AStar planner(cost.cells.size());
  const std::array<Cell, 1> goal{Cell{180, 24}};
  const PathResult path = planner.plan(cost, {10, 24}, goal);
  REQUIRE(path.status == PathStatus::found);
  PathSmoother smoother;
  double weighted = 0.0;
  for (std::size_t i = 1; i < path.cells.size(); ++i) {
    const double step = std::hypot(path.cells[i].x - path.cells[i - 1].x, path.cells[i].y - path.cells[i - 1].y);
    weighted += step * (kStraightCost + 0.8 * cost.at(path.cells[i]));
  }
  (void)smoother.smooth(cost, path.cells, {});
  double smooth_weighted = 0.0;
  const std::span<const std::uint32_t> corners = smoother.corners();
  for (std::size_t k = 1; k < corners.size(); ++k) {
    smooth_weighted += cost_of_line(cost, path.cells[corners[k - 1]], path.cells[corners[k]], 100).total;
  }
  CHECK(smooth_weighted <= weighted + 1e-6);
}

TEST_CASE("Short paths and long ones") {
  Costs cost(0.05, 0, 0, 300, 3, kFreeCost);
  PathSmoother smoother(100);
  CHECK(smoother.smooth(cost, {}, {}).empty());
  std::vector<Cell> path{{5, 1}};
  CHECK(smoother.smooth(cost, path, {}).size() == 1);
  for (int x = 6; x < 280; ++x) path.push_back({x, 1});
  const std::span<const Waypoint> cut = smoother.smooth(cost, path, {});
  CHECK(cut.back() == Waypoint{cost.centre_x_m({104, 1}), cost.centre_y_m({104, 1})});
  CHECK(smoother.smooth(cost, path, {.spacing_m = 1e-9}).size() < 400);
}
