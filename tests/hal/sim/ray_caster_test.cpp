// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/ray_caster.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "hal/sim/camera_path.hpp"
#include "hal/sim/load_world.hpp"
#include "hal/sim/world_query.hpp"

using namespace g3d::hal;

namespace {

CameraModel small_camera() {
  CameraModel camera;
  camera.width_px = 150;  // not a multiple of the tile
  camera.height_px = 110;
  camera.fx_px = camera.fy_px = 120.0F;
  camera.cx_px = 74.5F;
  camera.cy_px = 54.5F;
  return camera;
}

/// Pixels whose depth differs from the plain ray cast by more than a tenth of a millimetre per metre.
std::size_t count_different(const World& world, const Pose& pose, TimeNs time_ns) {
  const CameraModel camera = small_camera();
  RayCaster caster(world, camera, 1);
  ExactView view(camera);
  caster.render(pose, time_ns, view);
  const RigidTransform T = to_transform(pose);
  std::size_t different = 0;
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      const double x = (u - static_cast<double>(camera.cx_px)) / camera.fx_px;
      const double y = (v - static_cast<double>(camera.cy_px)) / camera.fy_px;
      std::array<double, 3> d{};
      for (std::size_t k = 0; k < 3; ++k) {
        d[k] = T.rotation[3 * k] * x + T.rotation[3 * k + 1] * y + T.rotation[3 * k + 2];
      }
      const RayHit hit = cast_ray(world, time_ns, {T.translation_m[0], T.translation_m[1], T.translation_m[2]}, d);
      const double expected = std::isfinite(hit.t) ? hit.t : 0.0;
      const double got = view.depth_m[static_cast<std::size_t>(v * camera.width_px + u)];
      if (std::abs(got - expected) > 1e-4 * (1.0 + expected)) ++different;
    }
  }
  return different;
}

}  // namespace

TEST_CASE("the tiled ray caster sees what a plain search over all solids sees", "[slow]") {
  for (const char* name : {"furnished_room", "office", "visitor"}) {
    const World world = load_world(name).value();
    const CameraPath path = load_camera_path(name).value();
    for (int i = 0; i < 8; ++i) {
      CAPTURE(name, i);
      const TimeNs t = path.begin_ns() + (path.end_ns() - path.begin_ns()) / 8 * i;
      // Outlines may fall to either side of a pixel's middle.
      CHECK(count_different(world, path.pose_at(t), t) <= 12);
    }
  }
}

TEST_CASE("solids across the image plane and behind the camera do no harm") {
  World world;
  world.add_box({0, 1, 0}, {30, 0.2, 2}, 0, Material{});  // a wall alongside, from far behind to far ahead
  world.add_box({-3, 0, 0}, {1, 1, 1}, 0, Material{});    // behind
  world.add_floor({0, 0, 0}, 40, 40, 0.1, Material{});
  for (const double yaw_deg : {0.0, 20.0, 80.0, 180.0}) {
    CHECK(count_different(world, camera_pose({0, 0, 1}, yaw_deg, -10), 0) <= 4);
  }
}

TEST_CASE("a pose that is rolled and looks straight down is rendered like any other") {
  const World world = load_world("furnished_room").value();
  const Pose down = camera_pose({-2.5, 1.0, 1.9}, 30, -90);
  const Pose rolled = compose(camera_pose({2.5, -1.0, 0.9}, 60, -20), {{0, 0, 0}, {0, 0, 0.6, 0.8}});
  CHECK(count_different(world, down, 0) <= 12);
  CHECK(count_different(world, rolled, 0) <= 12);
}

TEST_CASE("images are the same for any number of threads", "[threads]") {
  const World world = load_world("furnished_room").value();
  const CameraModel camera = small_camera();
  ExactView one(camera);
  RayCaster(world, camera, 1).render(camera_pose({2.5, 0, 0.5}, 170, 0), 0, one);
  for (const int threads : {2, 3, 7}) {
    RayCaster caster(world, camera, threads);
    for (int again = 0; again < 3; ++again) {
      ExactView many(camera);
      caster.render(camera_pose({2.5, 0, 0.5}, 170, 0), 0, many);
      CHECK(many.depth_m == one.depth_m);
      CHECK(many.rgb == one.rgb);
      CHECK(many.surface == one.surface);
    }
  }
}

TEST_CASE("dark matter is marked, glass is tinted and seen through") {
  World world;
  Material dark;
  dark.dark = true;
  Material pane;
  pane.colour = {0, 255, 255};
  pane.glass = true;
  world.add_box({3, 0, -2}, {0.2, 8, 6}, 0, Material{});
  world.add_box({2.5, 1, -2}, {0.2, 1, 6}, 0, dark);
  world.add_box({1.5, -1, -2}, {0.02, 1, 6}, 0, pane);
  const CameraModel camera = small_camera();
  ExactView view(camera);
  RayCaster(world, camera, 1).render(camera_pose({0, 0, 1}, 0, 0), 0, view);
  const std::size_t row = 54 * 150;
  const std::size_t on_dark = row + 74 - 48;  // y = +1 at x = 2.5
  const std::size_t on_pane = row + 74 + 80 * 3 / 4;
  const std::size_t on_wall = row + 74;
  CHECK((view.surface[on_dark] & ExactView::kDark) != 0);
  CHECK((view.surface[on_wall] & ExactView::kDark) == 0);
  CHECK((view.surface[on_wall] & ExactView::kCosineMask) >= 126);
  CHECK(view.depth_m[on_pane] == Approx(2.9));
  CHECK(view.rgb[3 * on_pane] < view.rgb[3 * on_wall]);  // less red
  CHECK(view.rgb[3 * on_pane + 1] >= view.rgb[3 * on_pane]);
  CHECK(view.depth_m[on_wall] == Approx(2.9));
}

TEST_CASE("a person is drawn where it is at that time") {
  const World world = load_world("visitor").value();
  const CameraModel camera = small_camera();
  RayCaster caster(world, camera, 1);
  ExactView view(camera);
  const Pose pose = camera_pose({-2, 0, 0.8}, 0, 0);
  const std::size_t middle = 54 * 150 + 75;
  caster.render(pose, 0, view);
  CHECK(view.depth_m[middle] > 4.0F);
  caster.render(pose, 8'500'000'000, view);
  CHECK(view.depth_m[middle] == Approx(0.68).margin(0.005));
  caster.render(pose, 13'000'000'000, view);
  CHECK(view.depth_m[middle] > 4.0F);
}

TEST_CASE("movers are drawn where the caller puts them, and a hidden one is not") {
  World world;
  world.add_box({5, 0, 0}, {0.2, 4, 4}, 0, {});
  const std::size_t mover = world.add_moving_cylinder(0.0, 0.25, 2.0, {});
  const CameraModel camera;
  RayCaster caster(world, camera, 1);
  ExactView view(camera);
  const Pose eye = look_at({0, 0, 1}, {1, 0, 1});
  const std::size_t middle = 240 * 640 + 320;
  const std::array<std::array<float, 2>, 1> ahead = {{{2.0F, 0.0F}}};
  caster.render(eye, ahead, -1, view);
  CHECK(view.depth_m[middle] == Approx(1.75).margin(1e-3));
  caster.render(eye, ahead, static_cast<std::int32_t>(mover), view);
  CHECK(view.depth_m[middle] == Approx(4.9).margin(1e-3));
}

TEST_CASE("a level camera sees walls of a grid exactly where single rays meet them") {
  std::vector<std::uint8_t> solid(120 * 100, 0);
  std::uint32_t state = 7;
  for (auto& cell : solid) {
    state = state * 1664525U + 1013904223U;
    cell = (state >> 24) < 12 ? 1 : 0;
  }
  World world;
  world.add_floor({3, 2.5, 0}, 20, 20, 0.1, {});
  world.set_grid(GridWalls(120, 100, 0.05F, {0.0F, 0.0F}, 0.0F, 0.9F, solid));
  CameraModel camera;
  camera.width_px = 160;
  camera.height_px = 120;
  camera.fx_px = camera.fy_px = 131.25F;
  camera.cx_px = 79.5F;
  camera.cy_px = 59.5F;
  RayCaster caster(world, camera, 1);
  ExactView view(camera);
  for (int k = 0; k < 12; ++k) {
    // Level, and for comparison looking down a little.
    const double a = 0.5236 * k + 0.1;
    const double down = k % 3 == 2 ? -0.1 : 0.0;
    const Pose eye = look_at({3.01, 2.52, 0.5}, {3.01 + std::cos(a), 2.52 + std::sin(a), 0.5 + down});
    caster.render(eye, 0, view);
    const RigidTransform t = to_transform(eye);
    for (int v = 0; v < 120; ++v) {
      for (int u = 0; u < 160; ++u) {
        const float x = (static_cast<float>(u) - camera.cx_px) / camera.fx_px;
        const float y = (static_cast<float>(v) - camera.cy_px) / camera.fy_px;
        const auto& r = t.rotation;
        const std::array<float, 3> d = {r[0] * x + r[1] * y + r[2], r[3] * x + r[4] * y + r[5],
                                        r[6] * x + r[7] * y + r[8]};
        const float wall = world.grid()->cast(t.translation_m, d, GridWalls::kMiss).t;
        const float seen = view.depth_m[static_cast<std::size_t>(v * 160 + u)];
        if (seen == 0.0F) {
          REQUIRE(wall == GridWalls::kMiss);
        } else if (seen != wall) {
          REQUIRE(seen < wall);
          REQUIRE(seen * d[2] == Approx(-t.translation_m[2]).epsilon(1e-3));  // the floor
        }
      }
    }
  }
}
