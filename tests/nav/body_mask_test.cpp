// SPDX-License-Identifier: Apache-2.0
#include "nav/body_mask.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "hal/frame_pool.hpp"
#include "hal/sim/sim_building.hpp"

using namespace g3d;

namespace {

constexpr double kBodyHeight_m = 0.6;

/// A wall 3 m ahead of a level camera 0.5 m above the floor, and everything else far away.
struct Look {
  hal::CameraModel camera = hal::scaled_kinect(160, 120);
  hal::Frame frame = hal::make_frame(camera);
  hal::Pose T_world_camera = hal::forward_camera();
  Look() {
    frame.stamp_ns = 7'000'000'000;
    for (int i = 0; i < camera.width_px * camera.height_px; ++i) frame.depth[static_cast<std::size_t>(i)] = raw(3.0);
  }
  [[nodiscard]] std::uint16_t raw(double z_m) const {
    return static_cast<std::uint16_t>(z_m * static_cast<double>(camera.depth_units_per_metre));
  }
  [[nodiscard]] std::size_t at(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width_px) + static_cast<std::size_t>(u);
  }
  /// A body 1.5 m ahead, as it is measured: its front, in the middle columns, from the camera's height downwards.
  void put_body() {
    for (int v = 60; v < 110; ++v) {
      for (int u = 68; u < 92; ++u) frame.depth[at(u, v)] = raw(1.35);
    }
  }
  [[nodiscard]] nav::TeamSight sight(double x_m) const {
    nav::TeamSight team;
    team.self = 1;
    team.count = 1;
    team.mates[0].robot = 2;
    team.mates[0].told_ns = frame.stamp_ns - 100'000'000;
    team.mates[0].T_world_base = {x_m, 0.0, 0.0};
    return team;
  }
};

}  // namespace

TEST_CASE("a teammate is taken out of the picture, and what stands behind him stays", "[nav][team]") {
  Look look;
  look.put_body();
  nav::BodyMask mask(look.camera, kBodyHeight_m);
  const hal::Frame& masked = mask.without_bodies(look.frame, look.T_world_camera, look.sight(1.5));
  REQUIRE(&masked != &look.frame);
  CHECK(masked.stamp_ns == look.frame.stamp_ns);
  int taken = 0, kept = 0;
  for (int v = 60; v < 95; ++v) {
    for (int u = 68; u < 92; ++u) taken += masked.depth[look.at(u, v)] == 1 ? 1 : 0;
  }
  CHECK(taken == 35 * 24);
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 160; ++u) kept += masked.depth[look.at(u, v)] == look.raw(3.0) ? 1 : 0;
  }
  CHECK(kept == 60 * 160);  // the wall above him and beside him
  CHECK(mask.masked_pixels() >= static_cast<std::uint64_t>(taken));
  CHECK(look.frame.depth[look.at(80, 70)] == look.raw(1.35));
}

TEST_CASE("a picture without teammates in view, or with old words, is left alone", "[nav][team]") {
  Look look;
  look.put_body();
  nav::BodyMask mask(look.camera, kBodyHeight_m);
  CHECK(&mask.without_bodies(look.frame, look.T_world_camera, {}) == &look.frame);
  CHECK(&mask.without_bodies(look.frame, look.T_world_camera, look.sight(-1.5)) == &look.frame);
  CHECK(&mask.without_bodies(look.frame, look.T_world_camera, look.sight(30.0)) == &look.frame);
  nav::TeamSight old = look.sight(1.5);
  old.mates[0].told_ns = look.frame.stamp_ns - 2'000'000'000;
  CHECK(&mask.without_bodies(look.frame, look.T_world_camera, old) == &look.frame);
  // He has said that he is elsewhere: what is measured here is something else.
  const hal::Frame& masked = mask.without_bodies(look.frame, look.T_world_camera, look.sight(2.4));
  CHECK(masked.depth[look.at(80, 70)] == look.raw(1.35));
}
