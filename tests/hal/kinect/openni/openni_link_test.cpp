// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/openni/openni_link.hpp"

#include <catch2/catch.hpp>

#include "hal/frame_pool.hpp"
#include "hal/kinect/kinect_camera.hpp"
#include "hal/kinect/oni_check.hpp"
#include "hal/kinect/openni/oni_camera.hpp"
#include "hal/kinect/openni/virtual_kinect.hpp"
#include "tests/support/shown_frames.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kinect;

TEST_CASE("a live Kinect where there is none, or no USB at all, is an error and not the end of the program") {
  struct Nobody final : ImageSink {
    void take(const SensorImage& /*image*/) override {}
  } nobody;
  const RealClock clock;
  const auto link = openni::make_openni_link(clock, {});
  for (int i = 0; i < 3; ++i) {
    const auto opened = link->open(nobody);
    if (opened.ok()) {
      WARN("there is a Kinect at this machine");
      return;
    }
    CHECK((opened.error().reason == Reason::not_found || opened.error().reason == Reason::unsupported));
    CHECK_FALSE(opened.error().text.empty());
  }
  link->close();
}

TEST_CASE("what a Kinect sees is recorded into an .oni file, and played from it again", "[openni_threads][slow]") {
  const g3d::test::TempFolder folder;
  const std::string path = folder / "eyes.oni";
  RealClock clock;
  const g3d::test::ShownFrames shown;
  std::vector<std::uint64_t> seen;
  {
    openni::VirtualKinect device([&](std::uint64_t number, Frame& out) { return shown.show(number, out), true; },
                                 clock);
    KinectCamera camera(openni::make_openni_link(clock, {openni::Driver::virtual_kinect, path}), clock, {});
    Frame frame = make_frame(camera.model());
    for (int i = 0; i < 20; ++i) {
      REQUIRE(camera.read(frame).event == CameraEvent::frame);
      seen.push_back(frame.sequence);
    }
  }
  const auto file = check_oni_file(path);
  if (!file) FAIL(file.error().text);
  CHECK(file.value().depth.frames >= 5);
  CHECK(file.value().has_colour());
  auto played = openni::open_oni_camera(path, {});
  if (!played) FAIL(played.error().text);
  Frame frame = make_frame(played.value()->model());
  CHECK(played.value()->model().fx_px == Approx(525.0).margin(1.0));
  // The recorder may have begun some images late, and counts its own: which one was the first is seen by its look.
  REQUIRE(played.value()->read(frame).event == CameraEvent::frame);
  std::uint64_t first = 1;
  frame.has_colour = false;  // JPEG loses
  while (first < 30 && !shown.is_frame(first, frame)) ++first;
  REQUIRE(first < 30);
  std::size_t count = 1;
  TimeNs last_ns = frame.stamp_ns;
  for (; played.value()->read(frame).event == CameraEvent::frame; ++count) {
    frame.has_colour = false;
    CHECK(shown.is_frame(first + count, frame));
    CHECK(frame.stamp_ns - last_ns == Approx(33.3e6).epsilon(0.01));
    last_ns = frame.stamp_ns;
  }
  CHECK(count == file.value().depth.frames);
}

TEST_CASE("recordings after the first get numbers") {
  CHECK(openni::numbered_path("a/eyes.oni", 1) == "a/eyes.oni");
  CHECK(openni::numbered_path("a/eyes.oni", 3) == "a/eyes-3.oni");
  CHECK(openni::numbered_path("a.b/eyes", 2) == "a.b/eyes-2");
  CHECK(openni::numbered_path("a/.eyes", 2) == "a/.eyes-2");
}
