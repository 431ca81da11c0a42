// SPDX-License-Identifier: Apache-2.0
#include "nav/goal_pursuit.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/support/voxel_floor.hpp"

using namespace g3d;
using nav::Way;
using tests::Box;

namespace {

constexpr double kStep_s = 0.02;
constexpr hal::TimeNs kSecond_ns = 1'000'000'000;

struct Scene {
  tests::KinematicRobot robot;
  tests::VoxelFloor floor{{-3, -3, 4, 3}};
  nav::Surroundings here;
  nav::GoalPursuit pursuit;
  hal::TimeNs now = 0;

  explicit Scene(const std::vector<Box>& boxes, const nav::PursuitConfig& pursued = {})
      : robot(boxes, {}), here(floor.map().grid(), config()), pursuit(here.states(), {}, pursued) {
    look();
  }
  static nav::SurroundingsConfig config() {
    nav::SurroundingsConfig c;
    c.ground.side_m = 12.8;
    return c;
  }
  void look() {
    here.on_pose(robot.pose(), now);
    floor.look(robot);
    here.on_map(floor.map(), floor.changed_slots(), robot.pose());
  }
  Way plan(const hal::PlanarPose& goal) { return pursuit.plan(here, robot.pose(), goal, true, false, now); }
  void step() {
    look();
    robot.step(pursuit.step(here, robot.pose(), robot.velocity()), kStep_s);
    now += static_cast<hal::TimeNs>(kStep_s * 1e9);
  }
};

}  // namespace

TEST_CASE("It drives to a goal, takes its heading, and says that it has arrived, in good time") {
  Scene scene({});
  CHECK(scene.pursuit.is_idle());
  REQUIRE(scene.plan({2.0, 0.5, 1.0}) == Way::open);
  scene.pursuit.allow_time(scene.now);
  while (!scene.pursuit.has_arrived() && scene.now < 30 * kSecond_ns) scene.step();
  REQUIRE(scene.pursuit.has_arrived());
  CHECK(std::hypot(scene.robot.pose().x_m - 2.0, scene.robot.pose().y_m - 0.5) < 0.2);
  CHECK(scene.robot.pose().heading_rad == Approx(1.0).margin(0.15));
  CHECK_FALSE(scene.pursuit.is_late(scene.now));
  CHECK(scene.pursuit.is_late(scene.now + 100 * kSecond_ns));
  CHECK_FALSE(scene.pursuit.takes_any_heading());
}

TEST_CASE("A goal without a way stops it, and it knows whether it could get anywhere at all") {
  Scene open({{1.5, -3, 1.7, 3}});
  CHECK(open.plan({3.0, 0.0, 0.0}) == Way::none);
  CHECK(open.pursuit.is_idle());
  CHECK_FALSE(open.pursuit.is_hemmed_in());
}

TEST_CASE("Time that it had to stand does not make a goal late") {
  Scene scene({});
  REQUIRE(scene.plan({2.0, 0.0, 0.0}) == Way::open);
  scene.pursuit.allow_time(0);
  const hal::TimeNs until = scene.pursuit.goal_until_ns();
  CHECK(scene.pursuit.is_late(until));
  scene.pursuit.leave_out(kSecond_ns);
  CHECK_FALSE(scene.pursuit.is_late(until));
  CHECK(scene.pursuit.is_late(until + kSecond_ns));
}

TEST_CASE("A path is planned anew now and then, sooner when its way closes, at once when asked for") {
  Scene scene({});
  REQUIRE(scene.plan({3.0, 0.0, 0.0}) == Way::open);
  for (int i = 0; i < 10; ++i) scene.step();
  CHECK_FALSE(scene.pursuit.wants_path(kSecond_ns));
  CHECK(scene.pursuit.wants_path(3 * kSecond_ns));
  CHECK_FALSE(scene.pursuit.closed_at());
  scene.robot.boxes().push_back({1.8, -3, 2.0, 3});
  for (int i = 0; i < 20; ++i) scene.step();
  REQUIRE(scene.pursuit.closed_at());
  CHECK(scene.pursuit.closed_at()->x_m == Approx(1.7).margin(0.2));
  CHECK(scene.pursuit.wants_path(kSecond_ns));
  scene.pursuit.refresh(scene.now);
  CHECK(scene.pursuit.wants_path(scene.now));
}

TEST_CASE("A way that stays shut in front of the body is shut for long after a moment, and not before") {
  Scene scene({});
  REQUIRE(scene.plan({3.0, 0.0, 0.0}) == Way::open);
  for (int i = 0; i < 25; ++i) scene.step();
  CHECK_FALSE(scene.pursuit.is_shut_for_long(scene.now));
  scene.robot.boxes().push_back({1.8, -3, 2.0, 3});
  for (int i = 0; i < 600 && !scene.pursuit.follower().is_shut(); ++i) scene.step();
  REQUIRE(scene.pursuit.follower().is_shut());
  const hal::TimeNs shut_ns = scene.now;
  CHECK_FALSE(scene.pursuit.is_shut_for_long(shut_ns));
  CHECK_FALSE(scene.pursuit.is_shut_for_long(shut_ns + kSecond_ns / 4));
  CHECK(scene.pursuit.is_shut_for_long(shut_ns + kSecond_ns / 2));
  scene.pursuit.forget_shut();
  CHECK_FALSE(scene.pursuit.is_shut_for_long(shut_ns + kSecond_ns));
}

TEST_CASE("Who knows the building plans where the robot has not looked yet, and around what it has not seen") {
  const std::vector<Box> boxes{{-1.2, -2.0, -1.0, 0.4}};
  CHECK(Scene(boxes).plan({-2.0, 0.0, 0.0}) == Way::none);
  const auto cost = tests::plain_costs(tests::known_floor(boxes, {-3, -3, 4, 3}), 0.215);
  nav::PursuitConfig pursued;
  pursued.known_cost = &cost;
  Scene scene(boxes, pursued);
  REQUIRE(scene.plan({-2.0, 0.0, 0.0}) == Way::open);
  CHECK(scene.pursuit.follower().track().length_m() > 2.2);
  scene.pursuit.allow_time(scene.now);
  while (!scene.pursuit.has_arrived() && scene.now < 60 * kSecond_ns) scene.step();
  CHECK(std::hypot(scene.robot.pose().x_m + 2.0, scene.robot.pose().y_m) < 0.2);
  CHECK(scene.robot.contacts() == 0);
}
