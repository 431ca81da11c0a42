// SPDX-License-Identifier: Apache-2.0
#include "hal/stream/frame_server.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <thread>
#include <vector>

#include "hal/stream/frame_reader.hpp"
#include "tests/support/temp_folder.hpp"
#include "tests/support/ticking_camera.hpp"

using namespace g3d;
using namespace g3d::hal;
using g3d::test::TickingCamera;

namespace {

bool soon(const std::function<bool()>& condition) {
  for (int i = 0; i < 2000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

struct Service {
  explicit Service(TimeNs period_ns) : camera(clock, 32, 24, period_ns) {
    auto link = StreamLink::listen(parse_stream_place(folder / "s").value());
    REQUIRE(link.ok());
    server = std::make_unique<FrameServer>(
        camera, [this] { camera.stop(); }, std::move(link).value(), clock, 100,
        [this](const Frame&) { seen.fetch_add(1); });
  }
  [[nodiscard]] StreamLink dial() const { return StreamLink::dial(parse_stream_place(folder / "s").value()); }

  test::TempFolder folder;
  RealClock clock;
  TickingCamera camera;
  std::atomic<int> seen{0};
  std::unique_ptr<FrameServer> server;
};

}  // namespace

TEST_CASE("frames go to whoever is there, and the camera rests while nobody is", "[threads]") {
  Service service(5'000'000);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  CHECK(service.seen.load() == 0);
  StreamLink reader_end = service.dial();
  REQUIRE(reader_end.connection(0) >= 0);
  FrameStreamReader reader(service.camera.model().pixel_count());
  std::uint64_t images = 0;
  CHECK(soon([&] {
    const auto room = reader.room();
    const ssize_t count = ::read(reader_end.fd(), room.data(), room.size());
    if (count > 0) reader.take(static_cast<std::size_t>(count));
    for (auto got = reader.next(); got != FrameStreamReader::Got::nothing; got = reader.next()) {
      if (got != FrameStreamReader::Got::image) continue;
      ++images;
      CHECK(reader.header().camera == service.camera.model());
    }
    return images >= 5;
  }));
  reader_end.hang_up(0);
  CHECK(soon([&] { return !service.server->counts().is_connected; }));
  const ServedCounts counts = service.server->counts();
  CHECK(counts.connections == 1);
  CHECK(counts.sent >= images);
  CHECK(counts.frames >= counts.sent);
}

TEST_CASE("a reader that does not read costs frames, which are counted, and never the camera's time", "[threads]") {
  Service service(1'000'000);
  StreamLink reader_end = service.dial();
  REQUIRE(reader_end.connection(0) >= 0);
  CHECK(soon([&] { return service.server->counts().slow_reader > 50; }));
  const ServedCounts stuck = service.server->counts();
  CHECK(service.seen.load() > 50);
  CHECK(stuck.sent < stuck.frames);
  // Another one takes its place and hears whole messages at once.
  StreamLink next = service.dial();
  REQUIRE(next.connection(0) >= 0);
  FrameStreamReader reader(service.camera.model().pixel_count());
  CHECK(soon([&] {
    const auto room = reader.room();
    const ssize_t count = ::read(next.fd(), room.data(), room.size());
    if (count > 0) reader.take(static_cast<std::size_t>(count));
    return reader.next() == FrameStreamReader::Got::image;
  }));
  CHECK(reader.skipped_bytes() == 0);
  CHECK(service.server->counts().cut_off >= 1);
  CHECK(service.server->counts().connections == 2);
}

TEST_CASE("a camera that has nothing to show is said to be alive", "[threads]") {
  Service service(3'600'000'000'000);
  StreamLink reader_end = service.dial();
  REQUIRE(reader_end.connection(0) >= 0);
  CHECK(soon([&] { return service.server->counts().signs_of_life >= 2; }));
}
