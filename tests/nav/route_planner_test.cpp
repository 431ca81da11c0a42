// SPDX-License-Identifier: Apache-2.0
#include "nav/route_planner.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/kinematic_robot.hpp"

using namespace g3d;
using nav::PathStatus;

namespace {

constexpr tests::Box kExtent{-4, -4, 4, 4};

nav::CellGrid<std::uint8_t> costs(const std::vector<tests::Box>& boxes) {
  return tests::plain_costs(tests::known_floor(boxes, kExtent), 0.199);
}

}  // namespace

TEST_CASE("A route begins at the robot, ends at the goal and keeps off what it would touch") {
  const auto cost = costs({{-0.1, -4, 0.1, 2}});
  nav::RoutePlanner planner(cost.cells.size());
  const nav::Route route = planner.plan(cost, {-2.013, 0.02, 1.0}, {2.017, -0.01, 0.0}, 0.0);
  REQUIRE(route.status == PathStatus::found);
  CHECK(route.points.front() == nav::Waypoint{-2.013, 0.02});
  CHECK(route.points.back() == nav::Waypoint{2.017, -0.01});
  CHECK(route.length_m > 5.6);  // around the end of the wall
  CHECK(route.length_m < 7.5);
  for (const auto& p : route.points) CHECK(cost.at(cost.cell_of(p.x_m, p.y_m)) < nav::kInscribedCost);
}

TEST_CASE("A goal where the body cannot be is taken for the nearest place where it can") {
  const auto cost = costs({{1.0, -4, 1.5, 4}});
  nav::RoutePlanner planner(cost.cells.size());
  CHECK(planner.plan(cost, {0, 0, 0}, {0.9, 0.0, 0.0}, 0.0).status == PathStatus::goal_blocked);
  const nav::Route route = planner.plan(cost, {0, 0, 0}, {0.9, 0.0, 0.0}, 0.3);
  REQUIRE(route.status == PathStatus::found);
  CHECK(std::hypot(route.points.back().x_m - 0.9, route.points.back().y_m) < 0.3);
  CHECK(planner.plan(cost, {0, 0, 0}, {1.25, 0.0, 0.0}, 0.2).status == PathStatus::goal_blocked);
}

TEST_CASE("Without a way it says so") {
  const auto cost = costs({{1.0, -4, 1.5, 4}});
  nav::RoutePlanner planner(cost.cells.size());
  const nav::Route route = planner.plan(cost, {0, 0, 0}, {3.0, 0.0, 0.0}, 0.2);
  CHECK(route.status == PathStatus::unreachable);
  CHECK(route.points.empty());
}

TEST_CASE("Through what nobody has seen it plans only if told to, also to a goal there") {
  auto cost = costs({{1.0, -4, 1.5, 4}});
  for (int y = 0; y < cost.rows; ++y) {
    for (int x = 0; x < cost.columns; ++x) {
      if (cost.centre_x_m({x, y}) > 0.3) cost.at({x, y}) = nav::kUnknownCost;
    }
  }
  nav::RoutePlanner planner(cost.cells.size());
  CHECK(planner.plan(cost, {0, 0, 0}, {2.0, 0.0, 0.0}, 0.0).status == PathStatus::goal_blocked);
  const nav::Route route = planner.plan(cost, {0, 0, 0}, {2.0, 0.0, 0.0}, 0.0, true);
  REQUIRE(route.status == PathStatus::found);
  CHECK(route.length_m == Approx(2.0).margin(0.1));
}

TEST_CASE("A goal in the robot's own cell is a route that is over") {
  const auto cost = costs({});
  nav::RoutePlanner planner(cost.cells.size());
  const nav::Route route = planner.plan(cost, {0.01, 0.01, 0}, {0.02, 0.02, 1.0}, 0.0);
  REQUIRE(route.status == PathStatus::found);
  CHECK(route.length_m < 0.05);
}

TEST_CASE("Hemmed in is who cannot get a metre away, not who cannot get to a goal") {
  const auto closed_goal = costs({{1.0, -4, 1.5, 4}});
  CHECK_FALSE(nav::is_hemmed_in(closed_goal, {0, 0, 0}));
  const auto pen =
      costs({{-0.6, -0.6, 0.6, -0.5}, {-0.6, 0.5, 0.6, 0.6}, {-0.6, -0.6, -0.5, 0.6}, {0.5, -0.6, 0.6, 0.6}});
  CHECK(nav::is_hemmed_in(pen, {0, 0, 0}));
  const auto gate = costs({{-0.6, -0.6, 0.6, -0.5}, {-0.6, 0.5, 0.6, 0.6}, {-0.6, -0.6, -0.5, 0.6}});
  CHECK_FALSE(nav::is_hemmed_in(gate, {0, 0, 0}));
  const auto wall = costs({{0.1, -4, 0.2, 4}});  // beside a wall, inside its inscribed costs
  CHECK_FALSE(nav::is_hemmed_in(wall, {0.0, 0, 0}));
  CHECK(nav::is_hemmed_in(wall, {99, 0, 0}));
}
