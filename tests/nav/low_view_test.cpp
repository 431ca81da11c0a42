// SPDX-License-Identifier: Apache-2.0
#include "nav/low_view.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "hal/frame_pool.hpp"
#include "hal/sim/sim_building.hpp"
#include "hal/sim/world_file.hpp"

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

TEST_CASE("With a depth image only what is measured has been looked at") {
  const Floor floor(0.05, -3.0, -3.0, 120, 120, CellState::free);
  const auto look = [&](const std::string& solids) {
    hal::SimBuildingOptions options;
    options.camera = hal::scaled_kinect(160, 120);
    options.robots.emplace_back();
    hal::SimBuilding building(hal::parse_world("floor 0 0 0 20 20 0.1\n" + solids, "w").value(), options);
    hal::Frame frame = hal::make_frame(options.camera);
    building.render(0, frame);
    nav::DepthScan scan({});
    scan.look(frame, options.camera);
    nav::LowView view(floor, {});
    view.look(floor, {}, &scan);
    return view;
  };
  const nav::LowView free = look("");
  for (double x = 0.82; x < 1.25; x += 0.05) CHECK(sees(free, floor, x, 0.0));
  CHECK_FALSE(sees(free, floor, 0.6, 0.0));
  // Black things that hide the floor, high and low ones; the map cannot know of them.
  for (const char* height : {"1.2", "0.3"}) {
    const nav::LowView black = look(std::string("box 1.4 0 0  0.9 0.6 ") + height + " dark\n");  // from x = 0.95 on
    CHECK_FALSE(sees(black, floor, 1.0, 0.0));
    CHECK_FALSE(sees(black, floor, 1.2, 0.0));
    CHECK(sees(black, floor, 1.1, 0.48));
  }
}
