// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/robot_body.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "hal/sim/world_file.hpp"

using namespace g3d::hal;

namespace {

struct Place {
  explicit Place(const char* text, const PlanarPose& start = {}, RobotBodyOptions options = {})
      : world(parse_world(text, "w").value()), floor(world), body(floor, start, -1, options) {
    body.place(start, {});
  }
  void drive(int speed_mmps, int radius_mm, double duration_s) {
    body.command(static_cast<std::int16_t>(speed_mmps), static_cast<std::int16_t>(radius_mm));
    for (double t = 0.0; t < duration_s; t += 0.002) body.step(0.002, {});
  }
  World world;
  FloorContact floor;
  RobotBody body;
};

}  // namespace

TEST_CASE("a free body goes where its wheels roll") {
  Place place("floor 0 0 0 20 20 0.1\n", {1, 2, 0});
  place.drive(300, 1000, 2.0);
  const PlanarPose begin = place.body.T_world_base();
  const double centre_x = begin.x_m - std::sin(begin.heading_rad);
  const double centre_y = begin.y_m + std::cos(begin.heading_rad);
  for (int i = 0; i < 10; ++i) {
    place.drive(300, 1000, 0.6);
    const PlanarPose at = place.body.T_world_base();
    REQUIRE(std::hypot(at.x_m - centre_x, at.y_m - centre_y) == Approx(1.0).margin(1e-6));
  }
  place.drive(0, 0, 1.0);
  const WheelPair way = place.body.wheel_way_m();
  CHECK(place.body.turned_rad() == Approx((way.right - way.left) / 0.23));
  CHECK(place.body.driven_m() == Approx((way.right + way.left) / 2));
  CHECK(way.right == Approx(0.3 * 8.0).margin(0.08));
  CHECK(place.body.velocity() == Twist{});
  CHECK_FALSE(place.body.sense().touching);
  CHECK(place.body.sense().bumper == 0);
}

TEST_CASE("a wall stops the body, presses the bumper and stalls the wheels; backing off is free") {
  Place place("floor 0 0 0 20 20 0.1\nbox 1 0 0  0.2 4 2\n");
  place.drive(200, 0, 6.0);
  CHECK(place.body.T_world_base().x_m == Approx(0.9 - 0.178).margin(2e-4));
  CHECK(place.body.T_world_base().x_m <= 0.9 - 0.178 + 1e-6);
  CHECK(place.body.sense().bumper == kobuki::kBumperCentre);
  CHECK(place.body.sense().stalled);
  CHECK(place.body.sense().touching);
  CHECK(place.body.wheel_way_m().left == Approx(0.722).margin(2e-4));  // encoders stand with the body
  place.drive(100, 1, 1.0);                                            // turning on the spot is free
  CHECK(place.body.T_world_base().heading_rad > 0.7);
  CHECK(place.body.sense().bumper == kobuki::kBumperRight);
  place.drive(-200, 0, 1.0);
  CHECK(place.body.sense().bumper == 0);
  CHECK_FALSE(place.body.sense().stalled);
  CHECK(place.body.sense().clearance_m > 0.05);
}

TEST_CASE("bumper bits follow the angle of the touch") {
  struct Row {
    double angle_deg;
    std::uint8_t bits;
  };
  for (const Row& row : {Row{0, kobuki::kBumperCentre}, Row{25, kobuki::kBumperCentre}, Row{35, kobuki::kBumperLeft},
                         Row{80, kobuki::kBumperLeft}, Row{-25, kobuki::kBumperCentre}, Row{-35, kobuki::kBumperRight},
                         Row{-80, kobuki::kBumperRight}, Row{120, 0}, Row{180, 0}}) {
    World world;
    const double angle = row.angle_deg * std::numbers::pi / 180;
    world.add_floor({0, 0, 0}, 10, 10, 0.1, {});
    world.add_cylinder({0.2795 * std::cos(angle), 0.2795 * std::sin(angle), 0}, 0.1, 1, {});
    const FloorContact floor(world);
    RobotBody body(floor, {}, -1, {});
    body.place({}, {});
    CAPTURE(row.angle_deg);
    CHECK(body.sense().bumper == row.bits);
    CHECK(body.sense().clearance_m == Approx(0.0015).margin(1e-5));
  }
}

TEST_CASE("a table edge above the bumper stops the body without a bumper bit, one above the mast does not") {
  Place low("floor 0 0 0 20 20 0.1\nbox 1 0 0.4  0.2 4 0.05\n");
  low.drive(200, 0, 6.0);
  CHECK(low.body.sense().touching);
  CHECK(low.body.sense().bumper == 0);
  CHECK(low.body.sense().stalled);
  Place high("floor 0 0 0 20 20 0.1\nbox 1 0 0.7  0.2 4 0.05\nbox 2 0 0  0.5 2 0.015\n");
  high.drive(200, 0, 6.0);
  CHECK(high.body.T_world_base().x_m > 1.05);
}

TEST_CASE("cliff sensors look down before the wheels drop") {
  Place place("floor 0 0 0  2 2 0.1\n");
  place.drive(100, 0, 8.5);  // the front sensor is 0.156 m ahead
  CHECK(place.body.sense().cliff == kobuki::kCliffCentre);
  CHECK(place.body.sense().wheel_drop == 0);
  place.drive(100, 0, 0.9);
  CHECK(place.body.sense().cliff == (kobuki::kCliffCentre | kobuki::kCliffLeft | kobuki::kCliffRight));
  place.drive(100, 0, 3.0);
  CHECK(place.body.sense().wheel_drop == (kobuki::kWheelDropLeft | kobuki::kWheelDropRight));
  CHECK(place.body.T_world_base().x_m == Approx(1.0).margin(0.01));
}

TEST_CASE("a hole to the left is seen by the left sensor alone") {
  Place place("floor 0 -1 0  4 2.2 0.1\n");  // up to y 0.1
  CHECK(place.body.sense().cliff == kobuki::kCliffLeft);
  CHECK(place.body.sense().wheel_drop == kobuki::kWheelDropLeft);
}

TEST_CASE("slip parts wheels from way, by its seed") {
  RobotBodyOptions options;
  options.slip = 0.05;
  Place a("floor 0 0 0 50 50 0.1\n", {}, options);
  Place b("floor 0 0 0 50 50 0.1\n", {}, options);
  options.seed = 2;
  Place c("floor 0 0 0 50 50 0.1\n", {}, options);
  for (Place* place : {&a, &b, &c}) place->drive(300, 0, 10.0);
  CHECK(a.body.T_world_base() == b.body.T_world_base());
  CHECK_FALSE(a.body.T_world_base() == c.body.T_world_base());
  CHECK(std::abs(a.body.T_world_base().heading_rad) > 1e-4);
  CHECK(a.body.wheel_way_m().left == a.body.wheel_way_m().right);
}
