// SPDX-License-Identifier: Apache-2.0
#include "nav/moved_lately.hpp"

#include <catch2/catch.hpp>

#include "tests/support/voxel_floor.hpp"

using namespace g3d;
using nav::CellState;
using tests::Box;

namespace {

constexpr hal::TimeNs kSecond_ns = 1'000'000'000;

struct Scene {
  tests::VoxelFloor voxels{{-3, -3, 4, 3}};
  nav::GroundMap ground;
  nav::MovedLately moved;

  Scene() : ground(voxels.map().grid(), config()), moved(ground.states()) {}
  static nav::GroundMapConfig config() {
    nav::GroundMapConfig c;
    c.side_m = 12.8;
    return c;
  }
  void see(const std::vector<Box>& boxes, hal::TimeNs now) {
    voxels.look(tests::KinematicRobot(boxes, {}));
    ground.update(voxels.map(), voxels.changed_slots());
    moved.note(ground, ground.changed_cells(), now);
  }
  [[nodiscard]] nav::Cell cell(double x_m, double y_m) const { return ground.states().cell_of(x_m, y_m); }
};

const Box kSomebody{1.5, -0.2, 1.9, 0.2};

}  // namespace

TEST_CASE("What came to stand on floor that was seen free has moved, for a while", "[nav][moved_lately]") {
  Scene scene;
  scene.see({}, kSecond_ns);
  CHECK_FALSE(scene.moved.is_new(scene.cell(1.52, 0.0), kSecond_ns));
  scene.see({kSomebody}, 2 * kSecond_ns);
  REQUIRE(scene.ground.states().at(scene.cell(1.52, 0.0)) == CellState::occupied);
  CHECK(scene.moved.is_new(scene.cell(1.52, 0.0), 2 * kSecond_ns));
  CHECK(scene.moved.is_new(scene.cell(1.52, 0.0), 31 * kSecond_ns));
  CHECK_FALSE(scene.moved.is_new(scene.cell(1.52, 0.0), 33 * kSecond_ns));
  CHECK_FALSE(scene.moved.is_new(scene.cell(2.5, 1.0), 2 * kSecond_ns));
  CHECK_FALSE(scene.moved.is_new({-1, 5}, 2 * kSecond_ns));
}

TEST_CASE("What stood there when it was first seen has not moved", "[nav][moved_lately]") {
  Scene scene;
  scene.see({kSomebody}, kSecond_ns);
  CHECK_FALSE(scene.moved.is_new(scene.cell(1.52, 0.0), kSecond_ns));
}

TEST_CASE("Where the floor was only presumed, what is found may have been there all the time", "[nav][moved_lately]") {
  Scene scene;
  scene.see({}, kSecond_ns);
  const nav::Cell presumed = scene.cell(0.9, 0.0);  // air alone: too near for the floor
  REQUIRE(scene.ground.states().at(presumed) == CellState::free);
  REQUIRE_FALSE(scene.ground.is_floor_seen(presumed));
  scene.see({{0.88, -0.2, 1.2, 0.2}}, 2 * kSecond_ns);
  REQUIRE(scene.ground.states().at(presumed) == CellState::occupied);
  CHECK_FALSE(scene.moved.is_new(presumed, 2 * kSecond_ns));
}
