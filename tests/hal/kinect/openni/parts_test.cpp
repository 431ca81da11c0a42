// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>

#include "hal/frame_pool.hpp"
#include "hal/kinect/kinect_camera.hpp"
#include "hal/kinect/openni_parts.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kinect;

TEST_CASE("a virtual link shows what another camera sees", "[openni_threads]") {
  struct Grey final : DepthCamera {
    CameraModel camera;
    [[nodiscard]] const CameraModel& model() const override { return camera; }
    [[nodiscard]] CameraRead read(Frame& out) override {
      std::fill_n(out.depth.get(), camera.pixel_count(), std::uint16_t{1234});
      std::fill_n(out.rgb.get(), 3 * camera.pixel_count(), std::uint8_t{56});
      return {CameraEvent::frame, {}};
    }
  } grey;
  RealClock clock;
  CHECK(is_openni_built_in());
  auto link = make_virtual_link(clock, {}, grey, 30.0);
  REQUIRE(link.ok());
  KinectCamera camera(std::move(link).value(), clock, {});
  Frame frame = make_frame(camera.model());
  REQUIRE(camera.read(frame).event == CameraEvent::frame);
  CHECK(frame.depth[4711] == 1234);
  CHECK(frame.rgb[4711] == 56);
  // One device at a time.
  CHECK(open_recording("/none.oni", nullptr).error().reason == Reason::not_found);
}
