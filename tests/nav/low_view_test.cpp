// SPDX-License-Identifier: Apache-2.0
#include "nav/low_view.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace g3d;
using nav::CellState;

namespace {

using Floor = nav::CellGrid<CellState>;

bool sees(const nav::LowView& view, const Floor& floor, double x_m, double y_m) {
  return view.is_seen(floor.cell_of(x_m, y_m));
}

}  // namespace

TEST_CASE("In view and far enough off, but not near and not to the side") {
  const Floor floor(0.05, -3.0, -3.0, 120, 120, CellState::free);
  nav::LowView view(floor, {});
  CHECK(view.low_m() == Approx(0.35 / std::tan(0.43)));
  view.look(floor, {0.5, 0.2, 1.0});
  const auto at = [&](double ahead_m, double bearing_rad) {
    return sees(view, floor, 0.5 + ahead_m * std::cos(1.0 + bearing_rad), 0.2 + ahead_m * std::sin(1.0 + bearing_rad));
  };
  for (double ahead = 0.85; ahead < 1.25; ahead += 0.01) {
    for (double bearing = -0.40; bearing <= 0.40; bearing += 0.01) CHECK(at(ahead, bearing));
  }
  CHECK_FALSE(at(0.6, 0.0));
  CHECK_FALSE(at(1.0, 0.6));
  CHECK_FALSE(at(1.0, -0.6));
  CHECK_FALSE(at(1.0, 3.1));
}

TEST_CASE("A camera that is tilted down, or lower, sees nearer floor") {
  const Floor floor(0.05, -3.0, -3.0, 120, 120, CellState::free);
  nav::LowViewConfig tilted;
  tilted.down_rad = 0.60;
  nav::LowViewConfig low;
  low.height_m = 0.3;
  CHECK(nav::LowView(floor, tilted).low_m() < nav::LowView(floor, {}).low_m() - 0.2);
  CHECK(nav::LowView(floor, low).low_m() < 0.4);
}

TEST_CASE("Nothing is seen behind what is occupied or unknown") {
  for (const CellState wall : {CellState::occupied, CellState::unknown}) {
    Floor floor(0.05, -3.0, -3.0, 120, 120, CellState::free);
    for (int y = 0; y < floor.rows; ++y) floor.at(floor.cell_of(0.9, -2.99 + 0.05 * y)) = wall;
    nav::LowView view(floor, {});
    view.look(floor, {0.0, 0.0, 0.0});
    CHECK(sees(view, floor, 0.85, 0.0));
    CHECK_FALSE(sees(view, floor, 0.92, 0.0));
    CHECK_FALSE(sees(view, floor, 1.1, 0.0));
  }
}
