// SPDX-License-Identifier: Apache-2.0
#include "nav/near_watch.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "hal/frame_pool.hpp"

using namespace g3d;
using nav::CellState;

namespace {

constexpr hal::TimeNs kSecond_ns = 1'000'000'000;

struct Scene {
  hal::CameraModel camera;
  hal::Frame frame;
  nav::CellGrid<CellState> floor{0.05, -3.0, -3.0, 120, 120, CellState::free};
  nav::NearWatch watch{floor, {}};
  nav::MovedLately moved{floor};

  Scene() {
    camera.width_px = 160;
    camera.height_px = 120;
    camera.fx_px = camera.fy_px = 131.25F;
    camera.cx_px = 79.5F;
    camera.cy_px = 59.5F;
    frame = hal::make_frame(camera);
    fill(0.0, 1.0, 1500);
  }
  /// Columns from `first` to `last` of the image's width read `raw`.
  void fill(double first, double last, std::uint16_t raw) {
    for (int v = 0; v < camera.height_px; ++v) {
      for (int u = static_cast<int>(first * camera.width_px); u < static_cast<int>(last * camera.width_px); ++u) {
        frame.depth[static_cast<std::size_t>(v * camera.width_px + u)] = raw;
      }
    }
  }
  void look(const hal::PlanarPose& pose = {}, hal::TimeNs now = 0) {
    watch.look(frame, camera, floor, moved, pose, now);
  }
  [[nodiscard]] bool is_suspect(double x_m, double y_m, hal::TimeNs now = 0) const {
    return watch.is_suspect(floor.cell_of(x_m, y_m), now);
  }
};

}  // namespace

TEST_CASE("A floor that is measured makes nothing suspect") {
  Scene scene;
  scene.look();
  CHECK(std::none_of(scene.watch.sectors().begin(), scene.watch.sectors().end(), [](bool s) { return s; }));
  CHECK_FALSE(scene.is_suspect(0.4, 0.0));
}

TEST_CASE("Whoever hides the floor makes what is before the camera suspect, for a while") {
  for (const std::uint16_t raw : {0, 620}) {  // too near to be measured, or measured too near
    Scene scene;
    scene.fill(0.0, 0.5, raw);  // the left half
    scene.look({}, kSecond_ns);
    CHECK(scene.is_suspect(0.4, 0.1, kSecond_ns));
    CHECK(scene.is_suspect(0.70, 0.25, kSecond_ns));
    CHECK_FALSE(scene.is_suspect(0.4, -0.1, kSecond_ns));
    CHECK_FALSE(scene.is_suspect(0.1, 0.0, kSecond_ns));  // below the robot itself
    CHECK_FALSE(scene.is_suspect(1.0, 0.3, kSecond_ns));  // there it would have been measured
    CHECK_FALSE(scene.is_suspect(-0.4, 0.1, kSecond_ns));
    CHECK(scene.is_suspect(0.4, 0.1, 3 * kSecond_ns));
    CHECK_FALSE(scene.is_suspect(0.4, 0.1, 4 * kSecond_ns));
  }
}

TEST_CASE("It is over as soon as the floor is measured again") {
  Scene scene;
  scene.fill(0.0, 1.0, 0);
  scene.look();
  CHECK(scene.is_suspect(0.4, 0.0));
  scene.fill(0.0, 1.0, 1300);
  scene.look();
  CHECK_FALSE(scene.is_suspect(0.4, 0.0));
}

TEST_CASE("What the map knows to stand there is no surprise") {
  Scene scene;
  for (int y = 0; y < scene.floor.rows; ++y)
    scene.floor.at(scene.floor.cell_of(0.62, -2.99 + 0.05 * y)) = CellState::occupied;
  scene.fill(0.0, 1.0, 0);
  scene.look();
  CHECK_FALSE(scene.is_suspect(0.4, 0.0));
}

TEST_CASE("A narrow gap is the shadow of something near") {
  Scene scene;
  scene.fill(0.45, 0.60, 0);
  scene.look();
  CHECK_FALSE(scene.is_suspect(0.4, 0.0));
}

TEST_CASE("At the image's edge a narrower gap will do: there is more of it outside") {
  Scene scene;
  scene.fill(0.0, 0.19, 0);
  scene.look();
  CHECK(scene.is_suspect(0.6, 0.27));
  CHECK_FALSE(scene.is_suspect(0.6, 0.0));
}

TEST_CASE("Bearings are the camera's, headings the world's") {
  Scene scene;
  scene.fill(0.0, 0.4, 0);
  scene.look({0.5, 0.5, 1.5708});
  CHECK(scene.is_suspect(0.5 - 0.15, 0.5 + 0.5));
  CHECK_FALSE(scene.is_suspect(0.5 + 0.15, 0.5 + 0.5));
}
