// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <catch2/catch.hpp>
#include <thread>
#include <vector>

#include "hal/frame_pool.hpp"
#include "hal/kinect/kinect_camera.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kinect;

namespace {

/// Time passes as the camera thread sleeps, and a sensor does what it does at its time.
class SensorClock final : public Clock {
 public:
  [[nodiscard]] TimeNs now() const override { return now_ns; }
  void sleep_until(TimeNs t_ns) override {
    now_ns = std::max(now_ns, t_ns);
    if (on_time) on_time();
  }
  TimeNs now_ns = 1'000'000'000;
  std::function<void()> on_time;
};

struct ScriptedLink final : SensorLink {
  explicit ScriptedLink(SensorClock& clock_) : clock(clock_) {
    depth.resize(std::size_t{kWidth_px} * kHeight_px);
    rgb.resize(3 * depth.size());
  }
  Result<SensorInfo> open(ImageSink& to) override {
    tries.push_back(clock.now_ns);
    if (!is_there) return Error{Reason::not_found, "no Kinect in the script"};
    sink = &to;
    lost = false;
    next_ns = clock.now_ns;
    number = first_number;
    return info;
  }
  void close() override { sink = nullptr; }
  [[nodiscard]] bool is_lost() const override { return lost; }

  /// Sends what is due.
  void run() {
    while (sink != nullptr && is_there && !is_silent && clock.now_ns >= next_ns) {
      ++number;
      send(ImageKind::colour, 3, rgb.data(), rgb.size());
      send(ImageKind::depth, 2, reinterpret_cast<const std::uint8_t*>(depth.data()),
           2 * depth.size() - (number == half_number ? 1000 : 0));
      next_ns += 33'333'333;
    }
  }
  void send(ImageKind kind, int pixel_bytes, const std::uint8_t* data, std::size_t bytes) const {
    SensorImage image;
    image.kind = kind;
    image.width_px = kWidth_px;
    image.height_px = kHeight_px;
    image.stride_bytes = kWidth_px * pixel_bytes;
    image.bytes = {data, bytes};
    image.index = number;
    image.device_ticks = 5'000'000 + number * 33'333ULL;
    image.arrived_ns = clock.now_ns;
    sink->take(image);
  }

  SensorClock& clock;
  SensorInfo info{"scripted", true, true, false, 1000.0, 64, 0.0};
  ImageSink* sink = nullptr;
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> rgb;
  std::vector<TimeNs> tries;
  TimeNs next_ns = 0;
  std::uint32_t number = 0, first_number = 0, half_number = 0;
  bool is_there = true, is_silent = false, lost = false;
};

struct CameraRig {
  explicit CameraRig(const KinectOptions& options = {}, const SensorInfo* info = nullptr) {
    auto made = std::make_unique<ScriptedLink>(clock);
    link = made.get();
    if (info != nullptr) link->info = *info;
    camera = std::make_unique<KinectCamera>(std::move(made), clock, options);
    frame = make_frame(camera->model());
    clock.on_time = [this] {
      link->run();
      if (script) script();
    };
  }
  SensorClock clock;
  ScriptedLink* link = nullptr;
  std::unique_ptr<KinectCamera> camera;
  Frame frame;
  std::function<void()> script;
};

}  // namespace

TEST_CASE("a Kinect's images become frames: depth in millimetres, colour, rising stamps and numbers") {
  CameraRig rig;
  rig.link->depth[5] = 1500;
  rig.link->rgb[7] = 99;
  REQUIRE(rig.camera->open().ok());
  TimeNs last_ns = 0;
  for (std::uint64_t i = 1; i <= 60; ++i) {
    REQUIRE(rig.camera->read(rig.frame).event == CameraEvent::frame);
    CHECK(rig.frame.sequence == i);
    CHECK(rig.frame.stamp_ns > last_ns);
    CHECK(std::abs(rig.frame.stamp_ns + 20 * kMillisecond_ns - rig.clock.now_ns) < 5 * kMillisecond_ns);
    last_ns = rig.frame.stamp_ns;
    CHECK(rig.frame.has_colour);
  }
  CHECK(rig.frame.depth[5] == 1500);
  CHECK(rig.frame.rgb[7] == 99);
  const KinectCounts counts = rig.camera->counts();
  CHECK(counts.frames == 60);
  CHECK(counts.opened == 1);
  CHECK(counts.missed + counts.colourless + counts.bad_depth + counts.stalled + counts.unplugged == 0);
  rig.camera->stop();
  CHECK(rig.camera->read(rig.frame).event == CameraEvent::end);
}

TEST_CASE("half an image is a dropped frame with its reason, and the next one is a frame") {
  CameraRig rig;
  rig.link->half_number = 3;
  std::vector<CameraEvent> events;
  for (int i = 0; i < 5; ++i) {
    const CameraRead read = rig.camera->read(rig.frame);
    events.push_back(read.event);
    if (read.event == CameraEvent::dropped) CHECK(read.reason == DropReason::unreadable_depth);
  }
  CHECK(events == std::vector<CameraEvent>{CameraEvent::frame, CameraEvent::frame, CameraEvent::dropped,
                                           CameraEvent::frame, CameraEvent::frame});
  CHECK(rig.camera->counts().bad_depth == 1);
}

TEST_CASE("a Kinect that is pulled out is looked for at growing intervals until it is back") {
  KinectOptions options;
  CameraRig rig(options);
  for (int i = 0; i < 10; ++i) REQUIRE(rig.camera->read(rig.frame).event == CameraEvent::frame);
  const TimeNs pulled_ns = rig.clock.now_ns;
  rig.link->is_there = false;
  rig.link->lost = true;
  rig.link->first_number = 500;
  rig.link->tries.clear();
  rig.script = [&] { rig.link->is_there = rig.clock.now_ns > pulled_ns + 20'000'000'000; };
  const TimeNs before_ns = rig.frame.stamp_ns;
  REQUIRE(rig.camera->read(rig.frame).event == CameraEvent::frame);
  CHECK(rig.frame.stamp_ns > before_ns + 19'000'000'000);
  // At once, then after 0.25, 0.5, 1, 2, 4, 4, ... s.
  REQUIRE(rig.link->tries.size() >= 7);
  CHECK(rig.link->tries.size() <= 11);
  for (std::size_t i = 2; i + 1 < rig.link->tries.size(); ++i) {
    const TimeNs wait_ns = rig.link->tries[i] - rig.link->tries[i - 1],
                 last_ns = rig.link->tries[i - 1] - rig.link->tries[i - 2];
    CHECK(wait_ns >= last_ns);
    CHECK(wait_ns <= options.last_retry_ns + 100 * kMillisecond_ns);
  }
  const KinectCounts counts = rig.camera->counts();
  CHECK(counts.unplugged == 1);
  CHECK(counts.opened == 2);
  CHECK(counts.open_failures + 1 == rig.link->tries.size());
  CHECK(counts.missed == 0);
  CHECK(rig.frame.sequence == 11);
}

TEST_CASE("a Kinect that falls silent is opened anew, one that stays silent not in a rush") {
  CameraRig rig;
  for (int i = 0; i < 10; ++i) REQUIRE(rig.camera->read(rig.frame).event == CameraEvent::frame);
  rig.link->is_silent = true;
  const TimeNs silent_ns = rig.clock.now_ns;
  rig.script = [&] { rig.link->is_silent = rig.clock.now_ns < silent_ns + 30'000'000'000; };
  REQUIRE(rig.camera->read(rig.frame).event == CameraEvent::frame);
  CHECK_THAT(rig.camera->last_error(), Catch::Contains("silent"));
  const KinectCounts counts = rig.camera->counts();
  CHECK(counts.stalled >= 4);
  CHECK(counts.stalled <= 7);
  CHECK(rig.link->tries.size() == counts.opened);
}

TEST_CASE("a robot that starts without a Kinect is told why, and gets frames once there is one") {
  CameraRig rig;
  rig.link->is_there = false;
  const auto opened = rig.camera->open();
  REQUIRE_FALSE(opened.ok());
  CHECK(opened.error().reason == Reason::not_found);
  rig.script = [&] { rig.link->is_there = rig.clock.now_ns > 5'000'000'000; };
  CHECK(rig.camera->read(rig.frame).event == CameraEvent::frame);
  rig.link->is_there = false;
  rig.link->lost = true;
  rig.script = [&] {
    if (rig.clock.now_ns > 60'000'000'000) rig.camera->stop();
  };
  CHECK(rig.camera->read(rig.frame).event == CameraEvent::end);
  CHECK_FALSE(rig.camera->counts().is_open);
}

TEST_CASE("a mirrored sensor is turned round, and depth that is not registered is registered here") {
  SensorInfo info{"scripted", true, true, true, 1000.0, 64, 0.0};
  {
    CameraRig rig({}, &info);
    rig.link->depth[0] = 1000;
    rig.link->rgb[1] = 7;
    REQUIRE(rig.camera->read(rig.frame).event == CameraEvent::frame);
    CHECK(rig.frame.depth[kWidth_px - 1] == 1000);
    CHECK(rig.frame.depth[0] == 0);
    CHECK(rig.frame.rgb[3 * (kWidth_px - 1) + 1] == 7);
  }
  info.is_mirrored = info.is_registered = false;
  CameraRig rig({}, &info);
  const std::size_t at = std::size_t{240} * kWidth_px + 420;
  rig.link->depth[at] = 2000;
  REQUIRE(rig.camera->read(rig.frame).event == CameraEvent::frame);
  CHECK(rig.frame.depth[at] == 0);
  std::size_t readings = 0;
  for (std::size_t i = 0; i < rig.camera->model().pixel_count(); ++i) readings += rig.frame.depth[i] == 2000;
  CHECK(readings == 1);
}
