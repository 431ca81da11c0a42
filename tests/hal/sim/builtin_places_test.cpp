// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>

#include "hal/sim/load_world.hpp"
#include "hal/sim/world_query.hpp"

using namespace g3d::hal;

TEST_CASE("no ray from the western of the two rooms reaches the eastern one or leaves the house") {
  const World world = load_world("two_rooms").value();
  const CameraPath path = load_camera_path("two_rooms").value();
  for (TimeNs t = path.begin_ns(); t <= path.end_ns(); t += 500'000'000) {
    const Pose pose = path.pose_at(t);
    for (int n = 0; n < 400; ++n) {
      const double yaw = 0.7 * n;
      const double up = -1.5 + 3.0 * n / 400;
      const std::array<double, 3> d = {std::cos(yaw) * std::cos(up), std::sin(yaw) * std::cos(up), std::sin(up)};
      const double t_hit = cast_ray(world, t, pose.translation_m, d, true).t;
      const auto at = [&](std::size_t k) { return pose.translation_m[k] + t_hit * d[k]; };
      REQUIRE(at(0) < -0.049);
      REQUIRE(at(0) > -4.06);
      REQUIRE(std::abs(at(1)) < 2.01);
      REQUIRE(at(2) > -0.01);
      REQUIRE(at(2) < 2.41);
    }
  }
}

TEST_CASE("the visitor comes into the zone that is too near and leaves the view") {
  const World world = load_world("visitor").value();
  const std::array<double, 3> eye = {-2, 0, 0.8};
  CHECK(cast_ray(world, 8'500'000'000, eye, {1, 0, 0}).t < 0.8);
  for (const TimeNs t : {TimeNs{0}, TimeNs{14'000'000'000}}) {
    for (double y = -0.6; y <= 0.6; y += 0.01) CHECK(cast_ray(world, t, eye, {1, y, 0}).t > 4.0);
  }
}

TEST_CASE("the office has a glass door that rays pass") {
  const World world = load_world("office").value();
  const double through = cast_ray(world, 0, {2.0, 0.75, 1.8}, {1, 0, 0}).t;
  const double pane = cast_ray(world, 0, {2.0, 0.75, 1.8}, {1, 0, 0}, true).t;
  CHECK(pane == Approx(0.485));
  CHECK(through > 3.0);
}
