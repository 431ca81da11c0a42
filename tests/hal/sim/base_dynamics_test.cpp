// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/base_dynamics.hpp"

#include <catch2/catch.hpp>

#include "hal/kobuki/base_control.hpp"

using namespace g3d::hal;

TEST_CASE("a command means what the encoder of commands meant") {
  const Twist wanted[] = {{0, 0},      {0.2, 0},     {-0.1, 0},   {0, 1},         {0, -1},
                          {0.2, 0.5},  {0.2, -0.5},  {-0.2, 0.5}, {-0.1, -0.4},   {0.02, 1.5},
                          {0.5, 0.05}, {-0.3, -1.2}, {0.7, 1.0},  {0.115, 1.0001}};
  for (const Twist& twist : wanted) {
    const kobuki::BaseControl command = kobuki::to_base_control(twist);
    const Twist done = twist_of(wheels_for_command(command.speed_mmps, command.radius_mm));
    CAPTURE(twist.forward_mps, twist.turn_radps, command.speed_mmps, command.radius_mm);
    CHECK(done.forward_mps == Approx(twist.forward_mps).margin(0.0015));
    CHECK(done.turn_radps == Approx(twist.turn_radps).margin(0.012));
  }
}

TEST_CASE("wheels follow with lag, never accelerate too much and arrive exactly") {
  BaseDynamicsOptions options;
  BaseDynamics base(options);
  base.command(500, 0);
  double before = 0.0;
  double t = 0.0;
  double reached = -1.0;
  double way = 0.0;
  for (int i = 0; i < 1000; ++i, t += 0.002) {
    way += base.step(0.002).left;
    const double speed = base.speeds_mps().left;
    REQUIRE(speed - before <= options.max_acceleration_mps2 * 0.002 + 1e-12);
    REQUIRE(speed <= 0.5);
    if (reached < 0 && speed > 0.475) reached = t;
    before = speed;
  }
  CHECK(base.speeds_mps().left == 0.5);
  CHECK(base.speeds_mps().right == 0.5);
  CHECK(reached > 0.2);  // 0.25 s at the limit alone
  CHECK(reached < 0.45);
  CHECK(way == Approx(0.5 * 2.0 - 0.5 * 0.17).margin(0.03));
  base.command(0, 0);
  for (int i = 0; i < 500; ++i) (void)base.step(0.002);
  CHECK(base.speeds_mps() == WheelPair{});
}

TEST_CASE("a base that cannot keep up keeps the curve") {
  BaseDynamicsOptions options;
  options.max_wheel_speed_mps = 0.7;
  BaseDynamics base(options);
  base.command(1400, 400);
  const WheelPair target = base.target_mps();
  CHECK(target.right == Approx(0.7));
  CHECK(target.left / target.right == Approx((0.4 - 0.115) / (0.4 + 0.115)));
}
