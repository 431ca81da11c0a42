// SPDX-License-Identifier: Apache-2.0
#include "nav/follower.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/support/kinematic_robot.hpp"

using namespace g3d;
using nav::CellState;
using nav::FollowerState;
using nav::Waypoint;
using tests::Box;
using tests::KinematicRobot;

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kStep_s = 0.02;
constexpr Box kExtent{-4, -4, 8, 8};

struct Drive {
  nav::CellGrid<CellState> ground;
  nav::CellGrid<std::uint8_t> cost;
  KinematicRobot robot;
  nav::Follower follower{nav::FollowerConfig{}};
  double time_s = 0.0;
  double fastest_mps = 0.0, fastest_turn_radps = 0.0;

  Drive(const std::vector<Box>& boxes, const hal::PlanarPose& start)
      : ground(tests::known_floor(boxes, kExtent)), cost(tests::plain_costs(ground)), robot(boxes, start) {}

  void step() {
    const hal::Twist twist = follower.step(robot.pose(), robot.velocity(), ground, cost);
    fastest_mps = std::max(fastest_mps, std::fabs(twist.forward_mps));
    fastest_turn_radps = std::max(fastest_turn_radps, std::fabs(twist.turn_radps));
    robot.step(twist, kStep_s);
    time_s += kStep_s;
  }
  bool arrives_within(double limit_s) {
    const double until_s = time_s + limit_s;
    while (time_s < until_s && follower.state() != FollowerState::arrived) step();
    return follower.state() == FollowerState::arrived;
  }
  [[nodiscard]] double distance_to(const Waypoint& p) const {
    return std::hypot(robot.pose().x_m - p.x_m, robot.pose().y_m - p.y_m);
  }
};

}  // namespace

TEST_CASE("A straight path is driven at full speed and ends in place, with the heading wanted") {
  Drive drive({}, {0, 0, 0});
  const std::vector<Waypoint> path{{0, 0}, {4, 0}};
  drive.follower.set_path(path, 0.5 * kPi);
  REQUIRE(drive.arrives_within(20));
  CHECK(drive.distance_to(path.back()) <= 0.12);
  CHECK(std::fabs(nav::wrap_angle(drive.robot.pose().heading_rad - 0.5 * kPi)) < 0.15);
  CHECK(drive.fastest_mps == Approx(0.5));
  // 4 m at 0.5 m/s, 0.5 s lost to acceleration and 0.5 s to braking, a quarter turn at 1.5 rad/s: 10.4 s.
  CHECK(drive.time_s < 11.5);
  drive.step();
  CHECK(drive.follower.state() == FollowerState::arrived);
}

TEST_CASE("A path that begins behind the robot is turned to on the spot") {
  for (const double heading : {kPi, 3.0, -2.5, 1.8, -1.3}) {
    Drive drive({{-2.0, -0.35, -0.30, 0.35}}, {0, 0, heading});  // something behind it, too near to swing out
    const std::vector<Waypoint> path{{0, 0}, {2, 0}};
    drive.follower.set_path(path, std::nullopt);
    CAPTURE(heading);
    REQUIRE(drive.arrives_within(12));
    CHECK(drive.robot.contacts() == 0);
    CHECK(drive.robot.rotation_rad() < std::fabs(heading) + 1.0);
    CHECK(drive.time_s < 8.5);
    CHECK(drive.fastest_turn_radps <= 1.5);
  }
}

TEST_CASE("Corners are cut where there is room and never into what stands in them") {
  const std::vector<Waypoint> path{{0, 0}, {2.0, 0}, {2.0, 2.0}, {4.0, 2.0}};
  Drive open({}, {0, 0, 0});
  open.follower.set_path(path, std::nullopt);
  REQUIRE(open.arrives_within(25));
  Drive tight({{0.5, 0.27, 1.73, 1.73}, {2.27, -1.0, 4.0, 1.73}, {0.0, 2.3, 4.0, 2.5}}, {0, 0, 0});
  tight.follower.set_path(path, std::nullopt);
  REQUIRE(tight.arrives_within(40));
  CHECK(open.robot.contacts() == 0);
  CHECK(tight.robot.contacts() == 0);
  CHECK(tight.robot.least_clearance_m() > 0.0);
  CHECK(open.time_s < tight.time_s);
  CHECK(open.time_s < 16.0);
  CHECK(tight.time_s < 25.0);
}

TEST_CASE("A door just wide enough is passed, also askew to the cells") {
  for (const double width_m : {0.56, 0.60, 0.70}) {
    for (const double shift_m : {0.0, 0.013, 0.025, 0.04}) {
      const double low = -0.5 * width_m + shift_m, high = 0.5 * width_m + shift_m;
      Drive drive({{1.5, -3.0, 1.62, low}, {1.5, high, 1.62, 3.0}}, {0, 0.6, 0});
      const std::vector<Waypoint> path{{0, 0.6}, {1.1, shift_m}, {2.0, shift_m}, {3.0, -0.5}};
      drive.follower.set_path(path, std::nullopt);
      CAPTURE(width_m, shift_m);
      CHECK(drive.arrives_within(30));
      CHECK(drive.robot.contacts() == 0);
    }
  }
}

TEST_CASE("What appears on the path is announced and never touched, from full speed") {
  for (const double appears_at_m : {0.55, 0.7, 1.0, 2.0}) {
    Drive drive({}, {0, 0, 0});
    const std::vector<Waypoint> path{{0, 0}, {6, 0}};
    drive.follower.set_path(path, std::nullopt);
    while (drive.robot.pose().x_m < 2.0) drive.step();
    REQUIRE(drive.robot.velocity().forward_mps == Approx(0.5));
    CHECK_FALSE(drive.follower.blocked_at_m());
    const double front_m = drive.robot.pose().x_m + appears_at_m;
    drive.robot.boxes().push_back({front_m, -0.5, front_m + 0.3, 0.5});
    drive.ground = tests::known_floor(drive.robot.boxes(), kExtent);
    drive.cost = tests::plain_costs(drive.ground);
    drive.step();
    CAPTURE(appears_at_m);
    REQUIRE(drive.follower.blocked_at_m());
    CHECK(*drive.follower.blocked_at_m() == Approx(appears_at_m - 0.2).margin(0.1));
    for (int i = 0; i < 250; ++i) drive.step();
    CHECK(drive.robot.contacts() == 0);
    CHECK(drive.robot.velocity().forward_mps == Approx(0.0).margin(1e-9));
    CHECK(drive.follower.is_shut());
    CHECK(drive.follower.limiter() == nav::SpeedLimiter::obstacle);
  }
}

TEST_CASE("It never drives faster than it can stop within what was seen free") {
  // A long corridor that becomes known only a little at a time.
  Drive drive({}, {0, 0, 0});
  for (auto& cell : drive.ground.cells) cell = CellState::unknown;
  const std::vector<Waypoint> path{{0, 0}, {5, 0}};
  drive.follower.set_path(path, std::nullopt);
  double known_until_m = 0.35;
  const nav::MotionLimits limits;
  for (int i = 0; i < 3000 && drive.follower.state() != FollowerState::arrived; ++i) {
    known_until_m += 0.006;  // 0.3 m/s
    for (std::size_t k = 0; k < drive.ground.cells.size(); ++k) {
      const auto c = drive.ground.cell(k);
      if (drive.ground.centre_x_m(c) < known_until_m) drive.ground.cells[k] = CellState::free;
    }
    drive.step();
    const double seen_m = known_until_m - drive.robot.pose().x_m - limits.body_radius_m;
    const double v = drive.robot.velocity().forward_mps;
    REQUIRE((v <= limits.crawl_speed_mps + 1e-9 || v * v / (2 * limits.deceleration_mps2) <= seen_m));
  }
  CHECK(drive.follower.state() == FollowerState::arrived);
}

TEST_CASE("Into the unknown it creeps, and looks there first") {
  Drive drive({}, {0, 0, 0.8});
  for (std::size_t k = 0; k < drive.ground.cells.size(); ++k) {
    const auto c = drive.ground.cell(k);
    if (drive.ground.centre_x_m(c) > 0.20) drive.ground.cells[k] = CellState::unknown;
  }
  const std::vector<Waypoint> path{{0, 0}, {1, 0}};
  drive.follower.set_path(path, std::nullopt);
  for (int i = 0; i < 20; ++i) drive.step();
  CHECK(drive.follower.state() == FollowerState::turning);
  while (drive.robot.pose().x_m < 0.1 && drive.time_s < 10.0) drive.step();
  drive.fastest_mps = 0.0;
  REQUIRE(drive.arrives_within(30));
  CHECK(drive.fastest_mps <= 0.1);
}

TEST_CASE("Between what noise may have put beside its own way it creeps") {
  struct OwnWay final : nav::FloorKnowledge {
    [[nodiscard]] bool is_seen(nav::Cell) const override { return true; }
    [[nodiscard]] nav::Extent extent(nav::Cell) const override { return nav::Extent::middle; }
  } own_way;
  // A gap of 35 cm between squares, of 40 cm between middles. What really stands there leaves 40 cm.
  Drive drive({}, {0, 0.025, 0});
  for (const double y_m : {0.22, -0.18}) {
    const nav::Cell c = drive.ground.cell_of(0.725, y_m);
    drive.ground.at(c) = CellState::occupied;
  }
  const std::vector<Waypoint> path{{0, 0.025}, {1.5, 0.025}};
  drive.follower.set_path(path, std::nullopt);
  double slowest_mps = 1.0;
  for (int i = 0; i < 3000 && drive.follower.state() != FollowerState::arrived; ++i) {
    const hal::Twist twist =
        drive.follower.step(drive.robot.pose(), drive.robot.velocity(), drive.ground, drive.cost, &own_way);
    const double ahead_m = 0.70 - drive.robot.pose().x_m;  // to the squares' near face
    if (std::fabs(ahead_m) < 0.1) slowest_mps = std::min(slowest_mps, twist.forward_mps);
    drive.robot.step(twist, kStep_s);
  }
  CHECK(drive.follower.state() == FollowerState::arrived);
  CHECK(slowest_mps > 0.0);  // as it gets between them; once it is, it is no deeper in
  CHECK(slowest_mps <= nav::MotionLimits{}.crawl_speed_mps + 1e-9);
}

TEST_CASE("Where somebody may have come unseen it turns to its way before it drives along it") {
  // What it looks at, 57 degrees, is watched.
  struct Watched final : nav::FloorKnowledge {
    const Drive* drive = nullptr;
    bool somebody_is_about = true;
    [[nodiscard]] bool is_seen(nav::Cell) const override { return true; }
    [[nodiscard]] bool is_unwatched(nav::Cell c) const override {
      const hal::PlanarPose pose = drive->robot.pose();
      const double bearing_rad =
          std::atan2(drive->ground.centre_y_m(c) - pose.y_m, drive->ground.centre_x_m(c) - pose.x_m);
      return somebody_is_about && std::fabs(nav::wrap_angle(bearing_rad - pose.heading_rad)) > 0.5;
    }
  } watched;
  for (const bool somebody_is_about : {false, true}) {
    Drive drive({}, {0, 0, 0});
    watched.drive = &drive;
    watched.somebody_is_about = somebody_is_about;
    const std::vector<Waypoint> path{{0, 0}, {1.5, 1.2}};  // 0.67 rad to the left
    drive.follower.set_path(path, std::nullopt);
    double turned_rad = 0.0;  // when it begins to drive
    for (int i = 0; i < 1000 && drive.follower.state() != FollowerState::arrived; ++i) {
      const hal::Twist twist =
          drive.follower.step(drive.robot.pose(), drive.robot.velocity(), drive.ground, drive.cost, &watched);
      if (twist.forward_mps > 0.0 && turned_rad == 0.0) turned_rad = drive.robot.pose().heading_rad;
      drive.robot.step(twist, kStep_s);
    }
    CHECK(drive.follower.state() == FollowerState::arrived);
    CHECK(turned_rad == (somebody_is_about ? Approx(0.67).margin(0.4) : Approx(0.0).margin(0.01)));
  }
}

TEST_CASE("A robot that stands against a wall drives away from it") {
  Drive drive({{-1.0, -1.0, 1.0, -0.179}}, {0, 0, 0});  // one millimetre from the body
  const std::vector<Waypoint> path{{0, 0}, {0.3, 0.3}, {2, 1}};
  drive.follower.set_path(path, std::nullopt);
  REQUIRE(drive.arrives_within(20));
  CHECK(drive.robot.contacts() == 0);
}

TEST_CASE("Beside obstacles it slows down") {
  Drive drive({{1.0, 0.23, 3.0, 0.5}, {1.0, -0.5, 3.0, -0.23}}, {0, 0, 0});
  const std::vector<Waypoint> path{{0, 0}, {4, 0}};
  drive.follower.set_path(path, std::nullopt);
  while (drive.robot.pose().x_m < 2.0 && drive.time_s < 30.0) drive.step();
  CHECK(drive.robot.velocity().forward_mps < 0.35);
  CHECK(drive.robot.velocity().forward_mps > 0.2);
  CHECK(drive.follower.limiter() == nav::SpeedLimiter::clearance);
  REQUIRE(drive.arrives_within(20));
  CHECK(drive.robot.contacts() == 0);
}

TEST_CASE("A path may be replaced while driving, or be a turn alone, or nothing") {
  Drive drive({}, {0, 0, 0});
  const std::vector<Waypoint> first{{0, 0}, {4, 0}};
  drive.follower.set_path(first, std::nullopt);
  for (int i = 0; i < 100; ++i) drive.step();
  const double speed_mps = drive.robot.velocity().forward_mps;
  const std::vector<Waypoint> second{{drive.robot.pose().x_m, 0}, {3, 1}};
  drive.follower.set_path(second, std::nullopt);
  drive.step();
  CHECK(drive.robot.velocity().forward_mps > speed_mps - 0.1);  // no stop in between
  REQUIRE(drive.arrives_within(20));
  drive.follower.set_path({}, -1.0);
  REQUIRE(drive.arrives_within(5));
  CHECK(drive.robot.pose().heading_rad == Approx(-1.0).margin(0.12));
  drive.follower.set_path({}, std::nullopt);
  CHECK(drive.follower.state() == FollowerState::idle);
  CHECK(drive.follower.step(drive.robot.pose(), {}, drive.ground, drive.cost) == hal::Twist{});
}
