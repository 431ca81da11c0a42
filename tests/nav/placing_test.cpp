// SPDX-License-Identifier: Apache-2.0
#include "nav/placing.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "hal/frame_pool.hpp"
#include "hal/sim/sim_building.hpp"
#include "hal/sim/sim_renderer.hpp"
#include "hal/sim/world_file.hpp"

using namespace g3d;
using namespace g3d::nav;

namespace {

void check_same(const hal::PlanarPose& a, const hal::PlanarPose& b, double within) {
  CHECK(a.x_m == Approx(b.x_m).margin(within));
  CHECK(a.y_m == Approx(b.y_m).margin(within));
  CHECK(std::remainder(a.heading_rad - b.heading_rad, 6.283185307179586) == Approx(0.0).margin(within));
}

hal::Pose on_floor(const hal::PlanarPose& p) { return hal::from_xyz_rpy(p.x_m, p.y_m, 0, 0, 0, p.heading_rad); }

}  // namespace

TEST_CASE("where odometry is believed nothing is touched", "[nav][placing]") {
  Placing placing(std::nullopt, hal::scaled_kinect(160, 120), {});
  Sight sight;
  sight.T_world_base = {1.0, 2.0, 3.0};
  sight.T_world_camera = on_floor({4.0, 5.0, 1.0});
  placing.place({}, mapper::VoxelMap(mapper::Grid{0.05F}, {64, 64, 64}), sight);
  check_same(sight.T_world_base, {1.0, 2.0, 3.0}, 0.0);
  CHECK(sight.T_world_camera.translation_m[0] == 4.0);
  check_same(placing.T_world_odometry(), {}, 0.0);
  CHECK(placing.aligner() == nullptr);
}

TEST_CASE("a robot whose odometry turns away is where its camera sees it", "[nav][placing][slow]") {
  const hal::CameraModel camera = hal::scaled_kinect(160, 120);
  const hal::Pose T_base_camera = hal::forward_camera(0.4);
  auto world = hal::parse_world(
      "room 0 0 0 8 6 2.5 0.1\nbox 2 1.5 0 0.8 0.6 0.7\nbox 3 -1.5 0 0.5 1.2 1.1 20\ncylinder 1.5 -1 0 0.2 1.2\n",
      "test.world");
  REQUIRE(world.ok());
  hal::SimRenderer renderer(std::move(world).value(), {.camera = camera});
  Placing placing(mapper::align::AlignOptions{}, camera, T_base_camera);
  const mapper::VoxelMap map(mapper::Grid{0.05F}, {64, 64, 64});
  hal::Frame frame = hal::make_frame(camera);
  hal::PlanarPose truth{-0.5, 0.2, 0.1};
  hal::PlanarPose odometry = truth;
  Sight sight;
  for (int i = 0; i < 40; ++i) {
    renderer.render(hal::compose(on_floor(truth), T_base_camera), i * 100'000'000LL, static_cast<std::uint64_t>(i),
                    frame);
    sight.T_world_base = odometry;
    sight.T_world_camera = hal::compose(on_floor(odometry), T_base_camera);
    placing.place(frame, map, sight);
    if (i == 39) break;
    truth = compose(truth, {0.03, 0.0, 0.0});
    odometry = compose(odometry, {0.031, 0.0, 0.002});
  }
  CHECK(std::hypot(odometry.x_m - truth.x_m, odometry.y_m - truth.y_m) > 0.05);
  check_same(sight.T_world_base, truth, 0.015);
  // Between frames, odometry carries on from there.
  check_same(compose(placing.T_world_odometry(), odometry), sight.T_world_base, 1e-12);
}
