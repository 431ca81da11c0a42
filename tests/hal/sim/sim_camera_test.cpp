// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/sim_camera.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "hal/frame_pool.hpp"
#include "hal/sim/load_world.hpp"

using namespace g3d::hal;

namespace {

SimCameraOptions small_options() {
  SimCameraOptions options;
  options.renderer.camera.width_px = 160;
  options.renderer.camera.height_px = 120;
  options.renderer.camera.fx_px = options.renderer.camera.fy_px = 131.25F;
  options.renderer.camera.cx_px = 79.5F;
  options.renderer.camera.cy_px = 59.5F;
  return options;
}

SimCamera make_camera(const std::string& name, const SimCameraOptions& options) {
  return SimCamera(load_world(name).value(), load_camera_path(name).value(), options);
}

double invalid_fraction(const Frame& frame, std::size_t pixels) {
  return static_cast<double>(std::count(frame.depth.get(), frame.depth.get() + pixels, 0)) /
         static_cast<double>(pixels);
}

}  // namespace

TEST_CASE("a simulated camera delivers duration * rate frames and then ends") {
  SimCameraOptions options = small_options();
  options.rate_hz = 3.0;
  options.first_sequence = 100;
  SimCamera camera = make_camera("two_rooms", options);
  REQUIRE(camera.frame_count() == 60U);
  Frame frame = make_frame(camera.model());
  const SimPoses poses(load_camera_path("two_rooms").value());
  for (std::size_t i = 0; i < 60; ++i) {
    REQUIRE(camera.read(frame).event == CameraEvent::frame);
    CHECK(frame.sequence == 100 + i);
    CHECK(frame.stamp_ns == std::llround(static_cast<double>(i) * 1e9 / 3.0));
    Pose pose;
    CHECK(poses.pose_at(frame.stamp_ns, pose) == PoseStatus::ok);
    CHECK(is_valid(pose));
  }
  CHECK(camera.read(frame).event == CameraEvent::end);
  CHECK(camera.read(frame).event == CameraEvent::end);
}

TEST_CASE("frames can be limited, and a camera at rest takes one") {
  SimCameraOptions options = small_options();
  options.max_frames = 7;
  CHECK(make_camera("furnished_room", options).frame_count() == 7U);
  options.max_frames.reset();
  CHECK(make_camera("furnished_room", options).frame_count() == 1800U);
  const auto still = parse_camera_path("5 0 0 1 0 0", "p");
  CHECK(SimCamera(load_world("visitor").value(), still.value(), options).frame_count() == 1U);
}

TEST_CASE("poses are known along the path alone") {
  const SimPoses poses(parse_camera_path("1 0 0 1 0 0\n2 1 0 1 0 0\n", "p").value());
  Pose pose;
  CHECK(poses.pose_at(999'999'999, pose) == PoseStatus::not_known);
  CHECK(poses.pose_at(1'000'000'000, pose) == PoseStatus::ok);
  CHECK(poses.pose_at(2'000'000'000, pose) == PoseStatus::ok);
  CHECK(pose.translation_m[0] == Approx(1.0));
  CHECK(poses.pose_at(2'000'000'001, pose) == PoseStatus::not_known);
}

TEST_CASE("the same seed gives the same frames, whatever the threads", "[threads]") {
  SimCameraOptions options = small_options();
  options.rate_hz = 0.5;
  SimCamera one = make_camera("furnished_room", options);
  options.renderer.threads = 3;
  SimCamera three = make_camera("furnished_room", options);
  Frame a = make_frame(one.model());
  Frame b = make_frame(one.model());
  const std::size_t n = one.model().pixel_count();
  while (one.read(a).event == CameraEvent::frame) {
    REQUIRE(three.read(b).event == CameraEvent::frame);
    REQUIRE(a.stamp_ns == b.stamp_ns);
    REQUIRE(std::equal(a.depth.get(), a.depth.get() + n, b.depth.get()));
    REQUIRE(std::equal(a.rgb.get(), a.rgb.get() + 3 * n, b.rgb.get()));
  }
}

TEST_CASE("on the drive through the furnished room 1 to 5 % of the pixels have no reading", "[slow]") {
  SimCameraOptions options;  // full size: edges and shadows are counted in pixels
  options.rate_hz = 0.7;
  SimCamera camera = make_camera("furnished_room", options);
  Frame frame = make_frame(camera.model());
  double sum = 0.0;
  std::size_t frames = 0;
  while (camera.read(frame).event == CameraEvent::frame) {
    sum += invalid_fraction(frame, camera.model().pixel_count());
    ++frames;
  }
  CHECK(frames == 42);
  CHECK(sum / static_cast<double>(frames) > 0.01);
  CHECK(sum / static_cast<double>(frames) < 0.05);
}
