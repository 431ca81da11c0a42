// SPDX-License-Identifier: Apache-2.0
#include "hal/stream/stream_camera.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <memory>
#include <thread>

#include "hal/frame_pool.hpp"
#include "hal/stream/frame_server.hpp"
#include "tests/support/temp_folder.hpp"
#include "tests/support/ticking_camera.hpp"

using namespace g3d;
using namespace g3d::hal;
using g3d::test::TickingCamera;

namespace {

constexpr TimeNs kPeriod_ns = 20'000'000;

/// A sender on a clock of its own.
struct Sender {
  explicit Sender(const std::string& path, TimeNs period_ns = kPeriod_ns) : camera(clock, 32, 24, period_ns) {
    auto link = StreamLink::listen(parse_stream_place(path).value());
    REQUIRE(link.ok());
    server = std::make_unique<FrameServer>(
        camera, [this] { camera.stop(); }, std::move(link).value(), clock, 100, nullptr);
  }
  RealClock clock;
  TickingCamera camera;
  std::unique_ptr<FrameServer> server;
};

/// An hour before.
class OtherClock final : public Clock {
 public:
  [[nodiscard]] TimeNs now() const override { return real_.now() + 3600 * TimeNs{1'000'000'000}; }
  void sleep_until(TimeNs t_ns) override { real_.sleep_until(t_ns - 3600 * TimeNs{1'000'000'000}); }

 private:
  RealClock real_;
};

struct Receiver {
  explicit Receiver(const std::string& path, int width_px = 32) {
    model.width_px = width_px;
    model.height_px = 24;
    model.cx_px = static_cast<float>(width_px - 1) / 2.0F;
    model.cy_px = 11.5F;
    frame = make_frame(model);
    camera = std::make_unique<StreamCamera>(parse_stream_place(path).value(), model, clock);
  }
  OtherClock clock;
  CameraModel model;
  Frame frame;
  std::unique_ptr<StreamCamera> camera;
};

}  // namespace

TEST_CASE("frames out of a stream carry the time of our own clock", "[threads]") {
  const test::TempFolder folder;
  const Sender sender(folder / "s");
  Receiver receiver(folder / "s");
  TimeNs last_ns = 0;
  const TimeNs begin_ns = receiver.clock.now();
  for (int i = 0; i < 20; ++i) {
    REQUIRE(receiver.camera->read(receiver.frame).event == CameraEvent::frame);
    const Frame& frame = receiver.frame;
    CHECK(frame.stamp_ns > last_ns);
    CHECK(frame.stamp_ns > begin_ns);
    CHECK(frame.stamp_ns <= receiver.clock.now());
    CHECK(frame.depth[3] == static_cast<std::uint16_t>(frame.sequence));
    CHECK(frame.rgb[100] == static_cast<std::uint8_t>(frame.sequence));
    last_ns = frame.stamp_ns;
  }
  // What came in the first second may have waited for us.
  CHECK(receiver.camera->counts().settling > 0);
  CHECK(last_ns - begin_ns > StreamCamera::kSettle_ns);
  CHECK(receiver.camera->counts().images == 20);
}

TEST_CASE("a stream that is empty for a while has nothing old in it", "[threads]") {
  const test::TempFolder folder;
  const Sender sender(folder / "s", 4 * StreamCamera::kQuiet_ns);
  Receiver receiver(folder / "s");
  const TimeNs begin_ns = receiver.clock.now();
  REQUIRE(receiver.camera->read(receiver.frame).event == CameraEvent::frame);
  CHECK(receiver.frame.stamp_ns > begin_ns);
  CHECK(receiver.frame.stamp_ns - begin_ns < StreamCamera::kSettle_ns);
  CHECK(receiver.camera->counts().settling <= 1);
}

TEST_CASE("a sender that goes and comes back is found again", "[threads]") {
  const test::TempFolder folder;
  auto sender = std::make_unique<Sender>(folder / "s");
  Receiver receiver(folder / "s");
  REQUIRE(receiver.camera->read(receiver.frame).event == CameraEvent::frame);
  sender.reset();
  std::thread later([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    sender = std::make_unique<Sender>(folder / "s");
  });
  const TimeNs gone_ns = receiver.clock.now();
  while (receiver.camera->read(receiver.frame).event == CameraEvent::frame) {
    if (receiver.frame.stamp_ns > gone_ns + 1'200'000'000) break;
  }
  later.join();
  CHECK(receiver.frame.stamp_ns > gone_ns);
  CHECK(receiver.camera->counts().connections == 2);
}

TEST_CASE("a sender that stays silent is left, and dialled again", "[threads][slow]") {
  const test::TempFolder folder;
  auto listening = StreamLink::listen(parse_stream_place(folder / "s").value());
  REQUIRE(listening.ok());
  Receiver receiver(folder / "s");
  std::thread reading([&] { CHECK(receiver.camera->read(receiver.frame).event == CameraEvent::end); });
  for (int i = 0; i < 3000 && listening.value().connections() < 2; ++i) {
    (void)listening.value().connection(0);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  receiver.camera->stop();
  reading.join();
  CHECK(receiver.camera->counts().stalls >= 1);
  CHECK(receiver.camera->counts().connections >= 2);
}

TEST_CASE("frames of another camera are dropped and named", "[threads]") {
  const test::TempFolder folder;
  const Sender sender(folder / "s");
  Receiver receiver(folder / "s", 40);
  const CameraRead read = receiver.camera->read(receiver.frame);
  CHECK(read.event == CameraEvent::dropped);
  CHECK(read.reason == DropReason::wrong_size);
  CHECK(receiver.camera->last_error().find("32x24") != std::string::npos);
  CHECK(receiver.camera->last_error().find("40x24") != std::string::npos);
}

TEST_CASE("a sender whose clock is slower than ours is named", "[threads]") {
  const test::TempFolder folder;
  const Sender sender(folder / "s");
  Receiver receiver(folder / "s");
  StreamCamera slow(parse_stream_place(folder / "s").value(), receiver.model, receiver.clock, 400);
  REQUIRE(slow.read(receiver.frame).event == CameraEvent::frame);
  CHECK(slow.last_error().find("1 times slow and ours 4 times") != std::string::npos);
}

TEST_CASE("who stops a camera without a sender does not wait", "[threads]") {
  const test::TempFolder folder;
  Receiver receiver(folder / "nobody");
  std::thread reading([&] { CHECK(receiver.camera->read(receiver.frame).event == CameraEvent::end); });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  receiver.camera->stop();
  reading.join();
  CHECK(receiver.camera->counts().connections == 0);
}
