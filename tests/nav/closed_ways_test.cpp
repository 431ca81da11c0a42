// SPDX-License-Identifier: Apache-2.0
#include "nav/closed_ways.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using nav::ClosedWay;
using nav::ClosedWays;

namespace {

nav::CellGrid<std::uint8_t> closed_everywhere() { return {0.1, -10.0, -10.0, 200, 200, nav::kInscribedCost}; }

}  // namespace

TEST_CASE("Each closed place is looked at a few times, the nearest first, from where it was seen") {
  const auto cost = closed_everywhere();
  ClosedWays ways;
  CHECK(ways.next(cost, {}) == nullptr);
  ways.note({5, 0}, {3, 0, 2.0});
  ways.note({5.3, 0.2}, {1, 0, 2.0});  // the same
  ways.note({-2, 0}, {-2, 1, 0.0});
  CHECK(ways.size() == 2);
  ClosedWay* way = ways.next(cost, {0, 0, 0});
  REQUIRE(way != nullptr);
  CHECK(way->at.x_m == -2);
  CHECK(way->seen_from.heading_rad == Approx(-1.5708).margin(1e-3));
  ++way->looks;
  way = ways.next(cost, {0, 0, 0});
  REQUIRE(way != nullptr);
  CHECK(way->seen_from.x_m == 3);
  int looks = 1;
  while ((way = ways.next(cost, {0, 0, 0})) != nullptr && looks < 100) {
    ++way->looks;
    ++looks;
  }
  CHECK(looks == 2 * ClosedWays::kMostLooks);
}

TEST_CASE("A place that was found open since, or is merely unknown, is no closed way") {
  auto cost = closed_everywhere();
  ClosedWays ways;
  ways.note({5, 0}, {3, 0, 0});
  cost.at(cost.cell_of(5, 0)) = nav::kUnknownCost;
  CHECK(ways.next(cost, {}) == nullptr);
  CHECK(ways.size() == 0);
  cost.at(cost.cell_of(5, 0)) = 40;
  ways.note({5, 0}, {3, 0, 0});
  CHECK(ways.next(cost, {}) == nullptr);
}

TEST_CASE("Memory is bounded: the oldest place gives way") {
  const auto cost = closed_everywhere();
  ClosedWays ways;
  for (int i = 0; i < 40; ++i) ways.note({-9.0 + 0.45 * i, i % 2 ? 5.0 : -5.0}, {0, 0, 0});
  CHECK(ways.size() == ClosedWays::kMost);
}
