// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/real_time_building.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "hal/frame_pool.hpp"
#include "hal/kobuki/command.hpp"
#include "hal/kobuki/packet_reader.hpp"
#include "hal/sim/world_file.hpp"

using namespace g3d::hal;

namespace {

SimBuildingOptions one_robot() {
  SimBuildingOptions options;
  options.camera = scaled_kinect(64, 48);
  options.noise = false;
  options.robots.emplace_back();
  return options;
}

World hall() { return parse_world("floor 0 0 0 40 40 0.1\nbox 3 0 0 0.2 10 3\n", "w").value(); }

}  // namespace

TEST_CASE("a base behind a terminal talks at 50 Hz, obeys and is seen to move", "[threads]") {
  RealClock clock;
  auto started = RealTimeBuilding::start(hall(), one_robot(), clock);
  REQUIRE(started.ok());
  RealTimeBuilding& building = *started.value();
  const int host = ::open(building.path(0).c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
  REQUIRE(host >= 0);
  std::array<std::uint8_t, kobuki::kMaxCommand_bytes> command;
  const std::size_t size_bytes = kobuki::encode_base_control({0.5, 0.0}, command);
  REQUIRE(::write(host, command.data(), size_bytes) == static_cast<ssize_t>(size_bytes));

  RealTimeBuilding::Camera camera(building, 0, 20.0);
  Frame frame = make_frame(camera.model());
  std::vector<kobuki::Feedback> got;
  kobuki::PacketReader reader;
  std::vector<std::uint16_t> middle;
  const std::size_t pixel = 24 * 64 + 32;
  TimeNs last_ns = 0;
  for (int i = 0; i < 20; ++i) {
    REQUIRE(camera.read(frame).event == CameraEvent::frame);
    CHECK(frame.stamp_ns > last_ns);
    CHECK(clock.now() - frame.stamp_ns < 300'000'000);
    last_ns = frame.stamp_ns;
    middle.push_back(frame.depth[pixel]);
    std::array<std::uint8_t, 4096> bytes;
    const ssize_t n = ::read(host, bytes.data(), bytes.size());
    if (n > 0) {
      reader.feed(std::span(bytes).first(static_cast<std::size_t>(n)), clock.now(),
                  [&](const kobuki::Feedback& f) { got.push_back(f); });
    }
  }
  CHECK(got.size() > 30);
  CHECK(reader.rejects().total() == 0);
  CHECK(got.back().left_encoder_ticks > 1000);
  CHECK(middle.front() > 2500);
  CHECK(middle.back() < middle.front() - 200);
  camera.stop();
  CHECK(camera.read(frame).event == CameraEvent::end);
  const double driven_m = building.with(0, [](SimBuilding& b, BaseCable&) { return b.T_world_base(0).x_m; });
  CHECK(driven_m > 0.2);
  ::close(host);
}

TEST_CASE("a camera whose rail is off gives no frame until it is on again", "[threads]") {
  RealClock clock;
  auto started = RealTimeBuilding::start(hall(), one_robot(), clock);
  REQUIRE(started.ok());
  RealTimeBuilding& building = *started.value();
  const std::array<std::uint8_t, 8> off = {0xaa, 0x55, 0x04, 0x0c, 0x02, 0x70, 0x00, 0x7a};
  const std::array<std::uint8_t, 8> on = {0xaa, 0x55, 0x04, 0x0c, 0x02, 0xf0, 0x00, 0xfa};
  CHECK(building.with(0, [&](SimBuilding& b, BaseCable&) { return b.line(0).write(off); }));
  clock.sleep_until(clock.now() + 50'000'000);
  const TimeNs switched_ns = clock.now();
  std::thread later([&] {
    clock.sleep_until(switched_ns + 200'000'000);
    (void)building.with(0, [&](SimBuilding& b, BaseCable&) { return b.line(0).write(on); });
  });
  RealTimeBuilding::Camera camera(building, 0, 50.0);
  Frame frame = make_frame(camera.model());
  REQUIRE(camera.read(frame).event == CameraEvent::frame);
  CHECK(clock.now() - switched_ns >= 200'000'000);
  later.join();
}
