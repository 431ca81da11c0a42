// SPDX-License-Identifier: Apache-2.0
// How the way from a Kinect's driver to frames lasts: a minute at 30 Hz without a loss, ten in `make soak`.
#include <catch2/catch.hpp>
#include <cmath>

#include "hal/frame_pool.hpp"
#include "hal/kinect/kinect_camera.hpp"
#include "hal/kinect/openni_parts.hpp"
#include "tests/support/shown_frames.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kinect;

namespace {

/// Shows images of the simulated camera, and remembers which.
class ShowingCamera final : public DepthCamera {
 public:
  [[nodiscard]] const CameraModel& model() const override { return model_; }
  [[nodiscard]] CameraRead read(Frame& out) override {
    shown_.show(++number_, out);
    return {CameraEvent::frame, {}};
  }
  [[nodiscard]] const g3d::test::ShownFrames& shown() const { return shown_; }

 private:
  CameraModel model_;
  g3d::test::ShownFrames shown_;
  std::uint64_t number_ = 0;
};

/// Frames of so many seconds: their number, and that none was lost, late beyond use or of another moment.
void watch_frames(double seconds) {
  if (!is_openni_built_in()) {
    WARN("this g3dmap was built without OpenNI2");
    return;
  }
  RealClock clock;
  ShowingCamera showing;
  auto link = make_virtual_link(clock, {}, showing, 30.0);
  REQUIRE(link.ok());
  KinectCamera camera(std::move(link).value(), clock, {});
  Frame frame = make_frame(camera.model());
  // The sensor's clock is believed after two seconds; until then stamps are arrivals.
  for (int i = 0; i < 90; ++i) REQUIRE(camera.read(frame).event == CameraEvent::frame);
  const std::uint64_t first = frame.sequence;
  const TimeNs begin_ns = frame.stamp_ns;
  const auto wanted = static_cast<std::uint64_t>(30.0 * seconds);
  std::uint64_t wrong = 0, colourless = 0;
  for (std::uint64_t i = 1; i <= wanted; ++i) {
    REQUIRE(camera.read(frame).event == CameraEvent::frame);
    wrong += frame.sequence != first + i;
    colourless += !frame.has_colour;
    // Some are compared whole: to compare each would take the time of a mapper.
    if (i % 10 == 0) wrong += !showing.shown().is_frame(frame.sequence, frame);
  }
  const double rate_hz = static_cast<double>(wanted) / (static_cast<double>(frame.stamp_ns - begin_ns) / 1e9);
  const KinectCounts counts = camera.counts();
  WARN(wanted << " frames at " << rate_hz << " Hz, " << counts.missed << " lost, " << colourless << " without colour");
  CHECK(std::abs(rate_hz - 30.0) < 0.05);
  CHECK(wrong == 0);
  CHECK(counts.missed == 0);
  CHECK(counts.depth_overruns == 0);
  CHECK(counts.bad_depth + counts.stalled + counts.unplugged == 0);
  CHECK(colourless <= wanted / 100);
}

}  // namespace

TEST_CASE("the virtual Kinect gives 30.0 Hz for a minute, and not one frame is lost", "[system][kinect][slow][waits]") {
  watch_frames(60.0);
}

TEST_CASE("the same for ten minutes", "[system][kinect][.soak]") { watch_frames(600.0); }
