// SPDX-License-Identifier: Apache-2.0
#include "nav/body_trace.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace g3d;
using nav::CellState;

namespace {

nav::CellGrid<CellState> floor_of(CellState state) { return {0.05, -2.0, -2.0, 80, 80, state}; }

}  // namespace

TEST_CASE("Where the body was is trodden, and nothing else") {
  const auto floor = floor_of(CellState::unknown);
  nav::BodyTrace trace(floor, 0.18);
  CHECK(trace.tread({0.0, 0.0, 0.0}));
  CHECK_FALSE(trace.tread({0.01, 0.0, 2.0}));
  CHECK(trace.tread({1.0, 0.0, 0.0}));
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < floor.cells.size(); ++i) {
    const nav::Cell c = floor.cell(i);
    const double x = floor.centre_x_m(c), y = floor.centre_y_m(c);
    const bool expected = std::hypot(x, y) <= 0.18 || std::hypot(x - 1.0, y) <= 0.18;
    wrong += trace.is_trodden(c) != expected ? 1 : 0;
  }
  CHECK(wrong == 0);
  CHECK_FALSE(trace.is_trodden({-1, 5}));
  CHECK(trace.tread({99.0, 0.0, 0.0}));  // outside of the grid: nothing to mark
}

TEST_CASE("A touch with nothing known nearby was in the middle of that part of the bumper") {
  const auto floor = floor_of(CellState::free);
  const nav::Waypoint ahead = nav::where_touched(floor, {0.5, 0.5, 0.0}, 0.0, 0.18);
  CHECK(ahead.x_m == Approx(0.5 + 0.21));
  CHECK(ahead.y_m == Approx(0.5));
  const nav::Waypoint left = nav::where_touched(floor, {0, 0, 1.0}, nav::kBumperSide_rad, 0.18);
  CHECK(std::atan2(left.y_m, left.x_m) == Approx(1.0 + nav::kBumperSide_rad));
}

TEST_CASE("A touch is blamed on what is known to stand at that part of the bumper") {
  auto floor = floor_of(CellState::free);
  floor.at(floor.cell_of(0.16, 0.16)) = CellState::occupied;  // ahead on the left, 0.25 m away
  const nav::Waypoint touched = nav::where_touched(floor, {0, 0, 0}, 0.0, 0.18);
  CHECK(std::atan2(touched.y_m, touched.x_m) == Approx(0.785).margin(0.01));
  CHECK(std::hypot(touched.x_m, touched.y_m) == Approx(0.21));
  // Not on the right, and not behind.
  const nav::Waypoint right = nav::where_touched(floor, {0, 0, 0}, -nav::kBumperSide_rad, 0.18);
  CHECK(std::atan2(right.y_m, right.x_m) == Approx(-nav::kBumperSide_rad));
  const nav::Waypoint behind = nav::where_touched(floor, {0, 0, 3.1}, 0.0, 0.18);
  CHECK(std::atan2(behind.y_m, behind.x_m) == Approx(3.1));
}
