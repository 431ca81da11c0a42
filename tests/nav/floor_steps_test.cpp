// SPDX-License-Identifier: Apache-2.0
#include "nav/floor_steps.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "hal/frame_pool.hpp"
#include "hal/sim/sim_building.hpp"
#include "hal/sim/world_file.hpp"

using namespace g3d;
using nav::Cell;
using nav::CellState;

namespace {

struct Scene {
  hal::SimBuilding building;
  hal::Frame frame;
  nav::CellGrid<CellState> floor{0.05, -4.0, -4.0, 160, 160, CellState::free};
  nav::FloorSteps steps{floor, {}};

  explicit Scene(const std::string& world, int width_px = 160)
      : building(hal::parse_world(world, "w").value(), options(width_px)), frame(hal::make_frame(building.camera())) {}
  static hal::SimBuildingOptions options(int width_px) {
    hal::SimBuildingOptions o;
    o.camera = hal::scaled_kinect(width_px, width_px * 3 / 4);
    o.robots.emplace_back();
    return o;
  }
  /// A second of noisy frames.
  void look(const hal::PlanarPose& pose = {}) {
    building.place(0, pose);
    for (int i = 0; i < 10; ++i) {
      building.render(0, frame);
      steps.look(frame, building.camera(), floor, pose);
    }
  }
  [[nodiscard]] bool is_step(double x_m, double y_m) const { return steps.is_step(floor.cell_of(x_m, y_m)); }
  /// Along a line across: how many of its cells have a step in them or right beside.
  [[nodiscard]] int along(double x_m, double from_y_m, double to_y_m) const {
    int found = 0;
    for (double y = from_y_m; y < to_y_m; y += 0.05) {
      found += is_step(x_m, y) || is_step(x_m + 0.05, y) || is_step(x_m - 0.05, y) ? 1 : 0;
    }
    return found;
  }
  [[nodiscard]] int all() const {
    int found = 0;
    for (std::size_t i = 0; i < floor.cells.size(); ++i) found += steps.is_step(floor.cell(i)) ? 1 : 0;
    return found;
  }
};

const std::string kFloor = "floor 0 0 0  16 16 0.1\n";

}  // namespace

TEST_CASE("A cable duct of three centimetres is a step, all along", "[nav][floor_steps]") {
  const auto check = [](double front_m, int width_px) {
    CAPTURE(width_px, front_m);
    Scene scene(kFloor + "box " + std::to_string(front_m + 0.06) + " 0 0  0.12 3 0.03\n", width_px);
    scene.look();
    CHECK(scene.along(front_m + 0.01, -0.5, 0.5) >= 18);
    CHECK(scene.all() <= 2 * scene.along(front_m + 0.01, -1.2, 1.2));
  };
  for (const double front_m : {1.25, 1.5, 1.75}) check(front_m, 160);
  check(1.4, 640);
}

TEST_CASE("An edge beyond which the floor lies four centimetres lower is a step", "[nav][floor_steps]") {
  Scene scene("floor -5 0 0  13 16 0.2\nfloor 5.5 0 -0.04  8 16 0.2\n");  // at x = 1.5
  scene.look();
  CHECK(scene.along(1.47, -0.5, 0.5) >= 18);
}

TEST_CASE("Free floor, a rug and what the map knows as obstacles are no steps", "[nav][floor_steps]") {
  for (const char* solids : {"", "box 1.7 0 0  0.6 1 0.015\n", "box 1.6 0 0  0.4 0.8 0.14\n", "box 1.4 0 0  0.2 6 1\n",
                             "pole 1.3 0.1 0 0.03 1\ncylinder 1.5 -0.3 0 0.15 0.4\n", "box 1.5 0 0 0.5 1 0.6 dark\n"}) {
    CAPTURE(solids);
    Scene scene(kFloor + solids);
    scene.look();
    scene.look({0.1, 0.05, 0.1});
    CHECK(scene.all() == 0);
  }
}

TEST_CASE("Beside an obstacle in the map nothing becomes a step", "[nav][floor_steps]") {
  Scene scene(kFloor + "box 1.46 0 0  0.12 3 0.03\n");
  for (int y = 0; y < scene.floor.rows; ++y)
    for (int x = -1; x <= 1; ++x) scene.floor.at({scene.floor.cell_of(1.41, 0).x + 2 * x, y}) = CellState::occupied;
  scene.look();
  CHECK(scene.all() == 0);
}

TEST_CASE("A step that is taken away is forgotten", "[nav][floor_steps]") {
  Scene scene(kFloor + "box 1.46 0 0  0.12 3 0.03\n");
  scene.look();
  const int before = scene.all();
  REQUIRE(before > 15);
  Scene free(kFloor);
  for (int i = 0; i < 30; ++i) {
    free.building.render(0, free.frame);
    scene.steps.look(free.frame, free.building.camera(), scene.floor, {});
  }
  CHECK(scene.all() == 0);
}

TEST_CASE("Places are in the world, and a camera that is mounted a degree wrong sees no steps", "[nav][floor_steps]") {
  Scene scene(kFloor + "box 0.5 1.96 0  3 0.12 0.03\n");
  scene.look({0.5, 0.5, 1.57079633});
  int found = 0;
  for (double x = 0.1; x < 0.9; x += 0.05) {
    found += scene.is_step(x, 1.88) || scene.is_step(x, 1.92) || scene.is_step(x, 1.97) ? 1 : 0;
  }
  CHECK(found >= 14);

  for (const double degrees : {-1.0, 1.0}) {
    Scene level(kFloor);
    nav::FloorStepsConfig config;
    const double rise_m = std::tan(degrees / 57.29578);
    config.T_base_camera = hal::look_at({0, 0, 0.5}, {1, 0, 0.5 + rise_m});
    level.steps = nav::FloorSteps(level.floor, config);
    level.look();
    CHECK(level.all() == 0);
  }
}

TEST_CASE("What changed is named", "[nav][floor_steps]") {
  Scene scene(kFloor + "box 1.46 0 0  0.12 3 0.03\n");
  std::vector<std::uint8_t> known(scene.floor.cells.size());
  for (int i = 0; i < 15; ++i) {
    scene.building.render(0, scene.frame);
    scene.steps.look(scene.frame, scene.building.camera(), scene.floor, {});
    for (const std::uint32_t cell : scene.steps.changed_cells())
      known[cell] = scene.steps.is_step(scene.floor.cell(cell));
  }
  for (std::size_t i = 0; i < known.size(); ++i) REQUIRE((known[i] != 0) == scene.steps.is_step(scene.floor.cell(i)));
  CHECK(scene.all() > 0);
}
