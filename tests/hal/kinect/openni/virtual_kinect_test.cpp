// SPDX-License-Identifier: Apache-2.0
// The whole way from a driver through OpenNI2 to frames, with a device that shows what the simulated camera saw.
#include "hal/kinect/openni/virtual_kinect.hpp"

#include <malloc.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "hal/frame_pool.hpp"
#include "hal/kinect/kinect_camera.hpp"
#include "hal/kinect/openni/openni_link.hpp"
#include "tests/support/shown_frames.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kinect;
using g3d::hal::kinect::openni::VirtualKinect;
using g3d::hal::kinect::openni::VirtualKinectOptions;

namespace {

struct VirtualRig {
  explicit VirtualRig(const VirtualKinectOptions& device_options = {}, const KinectOptions& options = {})
      : device([this](std::uint64_t number, Frame& out) { return shown.show(number, out), true; }, clock,
               device_options),
        camera(openni::make_openni_link(clock, {openni::Driver::virtual_kinect, {}}), clock, options),
        frame(make_frame(camera.model())) {}
  RealClock clock;
  g3d::test::ShownFrames shown;
  VirtualKinect device;
  KinectCamera camera;
  Frame frame;
};

}  // namespace

TEST_CASE("a virtual Kinect's images come through OpenNI2 unchanged, with colour and even stamps", "[openni_threads]") {
  VirtualRig rig;
  const auto opened = rig.camera.open();
  REQUIRE(opened.ok());
  TimeNs last_ns = 0;
  for (int i = 0; i < 45; ++i) {
    REQUIRE(rig.camera.read(rig.frame).event == CameraEvent::frame);
    CHECK(rig.shown.is_frame(rig.frame.sequence, rig.frame));
    CHECK(rig.frame.stamp_ns > last_ns);
    last_ns = rig.frame.stamp_ns;
  }
  CHECK(rig.camera.counts().colourless <= 5);  // on a machine that is busy with something else
}

TEST_CASE("one that cannot register depth is registered here", "[openni_threads]") {
  VirtualKinectOptions options;
  options.is_registered = false;
  VirtualRig rig(options);
  REQUIRE(rig.camera.read(rig.frame).event == CameraEvent::frame);
  CHECK_FALSE(rig.shown.is_frame(rig.frame.sequence, rig.frame));
  std::size_t readings = 0;
  for (std::size_t i = 0; i < rig.camera.model().pixel_count(); ++i) readings += rig.frame.depth[i] != 0;
  CHECK(readings > rig.camera.model().pixel_count() / 3);
}

TEST_CASE("half images, silence, and a plug that is pulled out and put back", "[openni_threads][slow]") {
  KinectOptions options;
  options.stall_ns = 400 * kMillisecond_ns;
  VirtualRig rig({}, options);
  REQUIRE(rig.camera.read(rig.frame).event == CameraEvent::frame);
  rig.device.send_half(1);
  bool was_dropped = false;
  for (int i = 0; i < 10 && !was_dropped; ++i) {
    const CameraRead read = rig.camera.read(rig.frame);
    was_dropped = read.event == CameraEvent::dropped && read.reason == DropReason::unreadable_depth;
  }
  CHECK(was_dropped);
  CHECK(rig.camera.counts().bad_depth == 1);

  rig.device.set_silent(true);
  std::thread later([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(900));
    rig.device.set_silent(false);
  });
  // What was under way still comes.
  while (rig.camera.counts().stalled == 0) REQUIRE(rig.camera.read(rig.frame).event == CameraEvent::frame);
  later.join();
  CHECK(rig.camera.read(rig.frame).event == CameraEvent::frame);

  rig.device.pull_out();
  std::thread back([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    rig.device.plug_in();
  });
  while (rig.camera.counts().unplugged == 0) REQUIRE(rig.camera.read(rig.frame).event == CameraEvent::frame);
  back.join();
  CHECK(rig.camera.read(rig.frame).event == CameraEvent::frame);
  CHECK(rig.camera.counts().is_open);
}

TEST_CASE("a Kinect that is pulled out and put back a hundred times gives frames each time", "[openni_threads][slow]") {
  VirtualKinectOptions options;
  options.rate_hz = 100.0;
  KinectOptions impatient;
  impatient.first_retry_ns = 5 * kMillisecond_ns;
  VirtualRig rig(options, impatient);
  std::atomic<bool> done{false};
  // Puts it back as soon as it is missed.
  std::thread hand([&] {
    for (std::uint64_t put_back = 0; !done.load();) {
      if (rig.camera.counts().unplugged > put_back) {
        ++put_back;
        rig.device.plug_in();
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  std::size_t begin_bytes = 0;
  for (std::uint64_t cycle = 1; cycle <= 100; ++cycle) {
    REQUIRE(rig.camera.read(rig.frame).event == CameraEvent::frame);
    rig.device.pull_out();
    // What was under way still comes.
    while (rig.camera.counts().unplugged < cycle) REQUIRE(rig.camera.read(rig.frame).event == CameraEvent::frame);
    if (cycle == 10) begin_bytes = mallinfo2().uordblks;
  }
  const double growth_bytes = (static_cast<double>(mallinfo2().uordblks) - static_cast<double>(begin_bytes)) / 90.0;
  done = true;
  hand.join();
  REQUIRE(rig.camera.read(rig.frame).event == CameraEvent::frame);
  const KinectCounts counts = rig.camera.counts();
  CHECK(counts.unplugged == 100);
  CHECK(counts.opened == 101);
  CHECK(counts.stalled + counts.bad_depth == 0);
  INFO("OpenNI2 keeps " << growth_bytes << " bytes for each time that it is started");
  CHECK(growth_bytes < 65536);
}

TEST_CASE("nothing plugged in is an error that says what to look at; stop() ends the wait", "[openni_threads]") {
  VirtualRig rig;
  rig.device.pull_out();
  const auto opened = rig.camera.open();
  REQUIRE_FALSE(opened.ok());
  CHECK(opened.error().reason == Reason::not_found);
  CHECK_THAT(opened.error().text, Catch::Contains("plugged in"));
  std::thread stops([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    rig.camera.stop();
  });
  CHECK(rig.camera.read(rig.frame).event == CameraEvent::end);
  stops.join();
}
