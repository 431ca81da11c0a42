// SPDX-License-Identifier: Apache-2.0
#include "nav/passers.hpp"

#include <catch2/catch.hpp>
#include <string>

#include "hal/frame_pool.hpp"
#include "hal/sim/sim_building.hpp"
#include "hal/sim/world_file.hpp"
#include "tests/support/voxel_floor.hpp"

using namespace g3d;
using nav::CellState;

namespace {

constexpr hal::TimeNs kSecond_ns = 1'000'000'000;
const hal::CameraModel kCamera = hal::scaled_kinect(160, 120);

struct Scene {
  hal::Frame frame = hal::make_frame(kCamera);
  nav::CellGrid<CellState> floor{0.05, -4.0, -4.0, 160, 160, CellState::free};
  nav::MovedLately moved{floor};
  nav::DepthScan scan{{}};
  nav::Passers passers{floor, {}};

  /// A frame of a world with these solids, taken by a robot that stands here.
  void look(const std::string& solids, hal::TimeNs now = kSecond_ns, const hal::PlanarPose& pose = {}) {
    hal::SimBuildingOptions options;
    options.camera = kCamera;
    options.noise = false;
    options.robots.emplace_back().T_world_base = pose;
    hal::SimBuilding building(hal::parse_world("floor 0 0 0 20 20 0.1\n" + solids, "w").value(), options);
    building.render(0, frame);
    scan.look(frame, kCamera);
    passers.look(scan, floor, moved, pose, now);
  }
  [[nodiscard]] bool is_there(double x_m, double y_m, hal::TimeNs now = kSecond_ns) const {
    return passers.is_there(floor.cell_of(x_m, y_m), now);
  }
};

std::string somebody_at(double x_m, double y_m) {
  return "cylinder " + std::to_string(x_m) + " " + std::to_string(y_m) + " 0  0.2 1.8\n";
}

}  // namespace

TEST_CASE("Somebody on free floor is noticed in the first frame, near and far", "[nav][passers]") {
  for (const double x_m : {0.77, 1.12, 2.02}) {
    Scene scene;
    scene.look(somebody_at(x_m, 0.0));
    CHECK(scene.is_there(x_m - 0.2 + 0.01, 0.01));
    CHECK_FALSE(scene.is_there(x_m - 0.3, 0.01));
    CHECK_FALSE(scene.is_there(x_m - 0.19, 0.3));
  }
}

TEST_CASE("What the map knows to stand there is nobody, also where it is a cell off", "[nav][passers]") {
  Scene scene;
  for (int y = 0; y < scene.floor.rows; ++y)
    scene.floor.at(scene.floor.cell_of(1.07, -3.99 + 0.05 * y)) = CellState::occupied;
  scene.look("box 1.1 0 0  0.2 6 2\n");  // its front is at 1.0
  for (double y = -0.5; y < 0.5; y += 0.05) CHECK_FALSE(scene.is_there(1.01, y));
  scene.look("box 1.02 0 0  0.2 6 2\n");
  CHECK(scene.is_there(0.92, 0.01));
}

TEST_CASE("Who went away is forgotten as soon as the camera looks through the place", "[nav][passers]") {
  Scene scene;
  scene.look(somebody_at(1.22, 0.0));
  REQUIRE(scene.is_there(1.03, 0.01));
  scene.look(somebody_at(1.22, 0.4), kSecond_ns + 100'000'000);
  CHECK_FALSE(scene.is_there(1.03, 0.01));
  CHECK(scene.is_there(1.03, 0.4));
}

TEST_CASE("Who is out of sight is taken to stand there for a while", "[nav][passers]") {
  Scene scene;
  scene.look(somebody_at(1.22, 0.0));
  scene.look("", 2 * kSecond_ns, {0.0, 0.0, 1.5});  // it has turned away
  CHECK(scene.is_there(1.03, 0.01, 5 * kSecond_ns));
  CHECK_FALSE(scene.is_there(1.03, 0.01, 7 * kSecond_ns));
}

TEST_CASE("Whoever is too near to be measured is not forgotten at once", "[nav][passers]") {
  Scene scene;
  scene.look(somebody_at(0.82, 0.0));
  REQUIRE(scene.is_there(0.63, 0.01));
  scene.frame = hal::make_frame(kCamera);  // no reading at all
  scene.scan.look(scene.frame, kCamera);
  scene.passers.look(scene.scan, scene.floor, scene.moved, {}, 2 * kSecond_ns);
  CHECK(scene.is_there(0.63, 0.01, 2 * kSecond_ns));
}

TEST_CASE("Places are in the world, not before the robot", "[nav][passers]") {
  Scene scene;
  scene.look(somebody_at(0.5, 1.82), kSecond_ns, {0.5, 0.5, 1.57079633});
  CHECK(scene.is_there(0.51, 1.63));
}

TEST_CASE("Beside cells of somebody who came lately a reading counts by itself", "[nav][passers]") {
  // Twice the same picture and the same cells: once they stood there from the beginning, once somebody came.
  for (const bool came_lately : {false, true}) {
    Scene scene;
    tests::VoxelFloor voxels({-3, -3, 4, 3});
    nav::GroundMapConfig config;
    config.side_m = 12.8;
    nav::GroundMap ground(voxels.map().grid(), config);
    scene.floor = ground.states();
    scene.moved = nav::MovedLately(scene.floor);
    scene.passers = nav::Passers(scene.floor, {});
    const auto see = [&](const std::vector<tests::Box>& boxes) {
      voxels.look(tests::KinematicRobot(boxes, {}));
      ground.update(voxels.map(), voxels.changed_slots());
      scene.moved.note(ground, ground.changed_cells(), kSecond_ns);
    };
    if (came_lately) see({});
    see({{1.52, -0.2, 1.9, 0.2}});
    scene.floor = ground.states();
    REQUIRE(scene.floor.at(scene.floor.cell_of(1.52, 0.01)) == CellState::occupied);
    scene.look("box 1.68 0 0  0.4 0.4 1.8\n");  // its front is at 1.48, one cell nearer
    CHECK(scene.is_there(1.48, 0.01) == came_lately);
  }
}
