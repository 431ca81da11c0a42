// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/seen_cells.hpp"

#include <catch2/catch.hpp>

#include "hal/frame_pool.hpp"
#include "hal/sim/sim_building.hpp"
#include "hal/sim/world_file.hpp"

using namespace g3d::hal;

namespace {

struct Room {
  Room() : world(parse_world("room 0 0 0  6 4 2.5  0.1\n", "room").value()) {
    const std::vector<PlanarPose> starts{{0.0, 0.0, 0.0}};
    observable = find_observable(world, starts).value();
    options.camera = scaled_kinect(160, 120);
    options.noise = false;
    options.robots.resize(1);
  }
  World world;
  Observable observable;
  SimBuildingOptions options;
};

}  // namespace

TEST_CASE("what a camera has been shown grows with every place that it looks from, to nearly all", "[slow]") {
  Room room;
  SeenCells seen(room.observable);
  CHECK(seen.fraction() == 0.0);
  SimBuilding building(room.world, room.options);
  Frame frame = make_frame(room.options.camera);
  const auto look_from = [&](double x_m, double y_m, double heading_rad) {
    building.place(0, {x_m, y_m, heading_rad});
    building.render(0, frame);
    seen.look(frame, room.options.camera, building.T_world_camera(0));
  };
  look_from(0.0, 0.0, 0.0);
  const double once = seen.fraction();
  CHECK(once > 0.05);
  CHECK(once < 0.5);
  look_from(0.0, 0.0, 0.0);
  CHECK(seen.fraction() == once);
  for (const double x_m : {-2.0, 0.0, 2.0}) {
    for (const double y_m : {-1.0, 1.0}) {
      for (int turn = 0; turn < 24; ++turn) look_from(x_m, y_m, turn * 0.2618);
    }
  }
  CHECK(seen.fraction() > 0.95);
  CHECK(seen.fraction() <= 1.0);
}

TEST_CASE("cameras in one building see together what each has seen, and not twice") {
  Room room;
  SeenCells one(room.observable), two(room.observable);
  SimBuilding building(room.world, room.options);
  Frame frame = make_frame(room.options.camera);
  building.render(0, frame);
  one.look(frame, room.options.camera, building.T_world_camera(0));
  two.look(frame, room.options.camera, building.T_world_camera(0));
  CHECK(SeenCells::fraction({&one, &two}) == one.fraction());
  building.place(0, {0.0, 0.0, 3.14159});
  building.render(0, frame);
  two.look(frame, room.options.camera, building.T_world_camera(0));
  CHECK(SeenCells::fraction({&one, &two}) == two.fraction());
  CHECK(two.fraction() > one.fraction());
}

TEST_CASE("a frame without readings shows nothing") {
  Room room;
  SeenCells seen(room.observable);
  const Frame dark = make_frame(room.options.camera);
  seen.look(dark, room.options.camera, forward_camera());
  CHECK(seen.fraction() == 0.0);
}
