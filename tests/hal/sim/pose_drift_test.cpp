// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/pose_drift.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace g3d::hal;

namespace {

std::vector<StampedPose> straight(int count, double step_m, double period_s) {
  std::vector<StampedPose> poses;
  for (int i = 0; i < count; ++i) {
    poses.push_back({static_cast<TimeNs>(1e9 * period_s * i), from_xyz_rpy(step_m * i, 0, 0.3, -1.5, 0, -1.5)});
  }
  return poses;
}
double yaw_between(const Pose& a, const Pose& b) {
  const Pose d = compose(b, inverse(a));
  return 2.0 * std::atan2(d.rotation_xyzw[2], d.rotation_xyzw[3]);
}

}  // namespace

TEST_CASE("without errors the poses stay as they are", "[hal][sim][drift]") {
  const auto truth = straight(50, 0.03, 0.1);
  const auto same = drifted(
      truth, {.translation_scale = 1.0, .heading_bias_rad_per_s = 0.0, .heading_walk_rad_per_root_s = 0.0, .seed = 3});
  for (std::size_t i = 0; i < truth.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(same[i].T_world_camera.translation_m[k] == Approx(truth[i].T_world_camera.translation_m[k]).margin(1e-12));
    }
    CHECK(std::abs(yaw_between(truth[i].T_world_camera, same[i].T_world_camera)) < 1e-9);
    CHECK(same[i].stamp_ns == truth[i].stamp_ns);
  }
}

TEST_CASE("the parts of the drift are as large as stated", "[hal][sim][drift]") {
  const auto truth = straight(1001, 0.01, 0.1);  // 100 s, 10 m
  const PoseDrift none{.translation_scale = 1.0, .heading_bias_rad_per_s = 0.0, .heading_walk_rad_per_root_s = 0.0};
  PoseDrift scaled = none;
  scaled.translation_scale = 1.02;
  CHECK(std::abs(std::abs(drifted(truth, scaled).back().T_world_camera.translation_m[0] - 10.0) - 0.2) < 1e-9);
  PoseDrift biased = none;
  biased.heading_bias_rad_per_s = 0.001;
  CHECK(std::abs(yaw_between(truth.back().T_world_camera, drifted(truth, biased).back().T_world_camera)) ==
        Approx(0.1).epsilon(1e-3));
  PoseDrift walking = none;
  walking.heading_walk_rad_per_root_s = 0.01;
  double sum2 = 0.0;
  for (walking.seed = 1; walking.seed <= 200; ++walking.seed) {
    const double yaw = yaw_between(truth.back().T_world_camera, drifted(truth, walking).back().T_world_camera);
    sum2 += yaw * yaw;
  }
  CHECK(std::sqrt(sum2 / 200.0) == Approx(0.1).epsilon(0.15));
}

TEST_CASE("a robot's height and tilt do not drift, a hand-held camera's do", "[hal][sim][drift]") {
  const auto truth = straight(100, 0.03, 0.1);
  const Pose robot = drifted(truth, robot_drift(1)).back().T_world_camera;
  const Pose hand = drifted(truth, hand_held_drift(1)).back().T_world_camera;
  CHECK(robot.translation_m[2] == Approx(0.3).margin(1e-12));
  CHECK(std::abs(hand.translation_m[2] - 0.3) > 1e-4);
}

TEST_CASE("a seed is a drift, and drawn both ways", "[hal][sim][drift]") {
  const auto truth = straight(100, 0.03, 0.1);
  CHECK(drifted(truth, robot_drift(5)).back().T_world_camera.translation_m ==
        drifted(truth, robot_drift(5)).back().T_world_camera.translation_m);
  int longer = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto t = drifted(truth, robot_drift(seed)).back().T_world_camera.translation_m;
    longer += std::hypot(t[0], t[1]) > 2.97 ? 1 : 0;
  }
  CHECK(longer > 2);
  CHECK(longer < 18);
}

TEST_CASE("no poses drift to no poses", "[hal][sim][drift]") { CHECK(drifted({}, robot_drift(1)).empty()); }
