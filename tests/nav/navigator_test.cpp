// SPDX-License-Identifier: Apache-2.0
#include "nav/navigator.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "hal/kobuki/feedback.hpp"
#include "tests/support/voxel_floor.hpp"

using namespace g3d;
using nav::MissionState;
using tests::Box;

namespace {

constexpr double kStep_s = 0.02;
constexpr int kStepsPerFrame = 5;  // 10 Hz

nav::NavigatorConfig config_for(double side_m) {
  nav::NavigatorConfig config;
  config.ground.side_m = side_m;
  return config;
}

/// Walls around a rectangle.
std::vector<Box> room(const Box& inner) {
  constexpr double kThick_m = 0.15;
  return {{inner.x0_m - kThick_m, inner.y0_m - kThick_m, inner.x1_m + kThick_m, inner.y0_m},
          {inner.x0_m - kThick_m, inner.y1_m, inner.x1_m + kThick_m, inner.y1_m + kThick_m},
          {inner.x0_m - kThick_m, inner.y0_m, inner.x0_m, inner.y1_m},
          {inner.x1_m, inner.y0_m, inner.x1_m + kThick_m, inner.y1_m}};
}

struct World {
  tests::KinematicRobot robot;
  tests::VoxelFloor floor;
  nav::Navigator navigator;
  hal::TimeNs now = 0;
  int steps = 0;
  std::uint8_t bumper = 0;
  hal::Verdict verdict{hal::SafetyState::free, hal::free_allowance(), hal::Condition::count_};

  World(const std::vector<Box>& boxes, const hal::PlanarPose& start, const Box& extent)
      : robot(boxes, start), floor(extent), navigator(floor.map().grid(), config_for(25.6)) {}

  void step() {
    nav::BaseView view;
    view.T_world_base = robot.pose();
    view.velocity = robot.velocity();
    view.bumper = robot.is_touching() && robot.velocity().forward_mps >= 0.0 ? hal::kobuki::kBumperCentre : bumper;
    view.verdict = verdict;
    navigator.on_base(view, now);
    if (steps++ % kStepsPerFrame == 0) {
      floor.look(robot);
      navigator.on_map(floor.map(), floor.changed_slots(), now);
    }
    robot.step(hal::permit(navigator.step(now), verdict.allowance), kStep_s);
    now += static_cast<hal::TimeNs>(kStep_s * 1e9);
  }
  bool reaches(MissionState state, double limit_s) {
    const hal::TimeNs until = now + static_cast<hal::TimeNs>(limit_s * 1e9);
    while (now < until && navigator.mission().state() != state) step();
    return navigator.mission().state() == state;
  }
  [[nodiscard]] double time_s() const { return static_cast<double>(now) * 1e-9; }
};

/// Two rooms with a door 0.60 m wide between them, a cupboard in one and a table in the other.
std::vector<Box> two_rooms() {
  std::vector<Box> boxes = room({0, 0, 8, 4});
  boxes.push_back({3.9, 0, 4.03, 1.5});
  boxes.push_back({3.9, 2.1, 4.03, 4});
  boxes.push_back({0.0, 3.3, 1.0, 4.0});
  boxes.push_back({5.6, 1.0, 6.4, 1.6});
  return boxes;
}
constexpr Box kTwoRooms{-0.2, -0.2, 8.2, 4.2};

nav::CellGrid<nav::CellState> inside(const std::vector<Box>& boxes) {
  auto floor = tests::known_floor(boxes, {0, 0, 8, 4});
  return floor;
}

}  // namespace

TEST_CASE("It explores two rooms through a narrow door and returns home without touching anything") {
  World world(two_rooms(), {1.5, 1.5, 0.3}, kTwoRooms);
  CHECK(world.navigator.mission().state() == MissionState::starting);
  REQUIRE(world.reaches(MissionState::home, 300));
  CHECK(world.robot.contacts() == 0);
  CHECK(world.floor.coverage(inside(two_rooms())) > 0.985);
  CHECK(std::hypot(world.robot.pose().x_m - 1.5, world.robot.pose().y_m - 1.5) < 0.35);
  CHECK(world.navigator.report().path_m == Approx(world.robot.path_m()).epsilon(0.02));
  CHECK(world.navigator.report().goals_reached > 0);
  CHECK(world.navigator.decision().left.open == 0);
  CHECK(world.time_s() < 150);
}
