// SPDX-License-Identifier: Apache-2.0
#include "nav/path_centring.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

using namespace g3d::nav;

namespace {

/// A wall along x = 30, 31 with a gap of eight cells, 1.0 to 1.4 m.
CellGrid<std::uint8_t> wall_with_gap() {
  CellGrid<std::uint8_t> cost(0.05, 0.0, 0.0, 60, 60, 0);
  for (int y = 0; y < 60; ++y) {
    if (y >= 20 && y < 28) continue;
    cost.at({30, y}) = cost.at({31, y}) = kLethalCost;
  }
  return cost;
}

std::vector<Waypoint> straight(double y_m) {
  std::vector<Waypoint> path;
  for (int i = 0; i <= 40; ++i) path.push_back({0.5 + 0.05 * i, y_m});
  return path;
}

}  // namespace

TEST_CASE("the nearest square counts, up to a limit") {
  const auto cost = wall_with_gap();
  CHECK(clearance_to_squares_m(cost, {1.3, 0.5}, 0.3) == Approx(0.2));
  CHECK(clearance_to_squares_m(cost, {1.53, 1.2}, 0.3) == Approx(0.2));
  CHECK(clearance_to_squares_m(cost, {1.4, 1.1}, 0.3) == Approx(std::hypot(0.1, 0.1)));
  CHECK(clearance_to_squares_m(cost, {0.5, 1.2}, 0.3) == Approx(0.3));
  CHECK(clearance_to_squares_m(cost, {1.52, 0.5}, 0.3) == 0.0);
}

TEST_CASE("a path through a gap is moved to its middle, and only there") {
  const auto cost = wall_with_gap();
  for (const double y_m : {1.175, 1.225, 1.2}) {
    std::vector<Waypoint> path = straight(y_m);
    centre_path(cost, path, 0.25);
    for (const Waypoint& p : path) {
      if (p.x_m > 1.49 && p.x_m < 1.61) CHECK(p.y_m == Approx(1.2).margin(0.004));
      if (p.x_m < 1.2 || p.x_m > 1.9) CHECK(p.y_m == y_m);
      CHECK(std::fabs(p.y_m - y_m) < 0.051);
    }
  }
}

TEST_CASE("both ends stay, and so does a path along a wall but for what it gains") {
  const auto cost = wall_with_gap();
  std::vector<Waypoint> two{{1.5, 1.15}, {1.55, 1.15}};
  centre_path(cost, two, 0.25);
  CHECK(two[0].y_m == 1.15);
  CHECK(two[1].x_m == 1.55);
  std::vector<Waypoint> along;
  for (int i = 0; i < 10; ++i) along.push_back({1.3, 0.2 + 0.05 * i});
  centre_path(cost, along, 0.25);
  CHECK(along.front().x_m == 1.3);
  CHECK(along.back().x_m == 1.3);
  for (const Waypoint& p : along) {
    CHECK(p.x_m <= 1.3);
    CHECK(p.x_m > 1.249);
  }
}
