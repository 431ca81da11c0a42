// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/socket_cable.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal;

namespace {

/// Says what it is told to, and keeps what it hears.
class Device final : public ByteLine {
 public:
  std::size_t read(std::span<std::uint8_t> into) override {
    const std::size_t count = std::min(into.size(), to_say.size());
    std::copy_n(to_say.begin(), count, into.begin());
    to_say.erase(0, count);
    return count;
  }
  bool write(std::span<const std::uint8_t> bytes) override {
    heard.append(bytes.begin(), bytes.end());
    return true;
  }
  [[nodiscard]] LineState state() const override { return LineState::up; }
  std::string to_say, heard;
};

/// What is there now.
std::string taken(int fd) {
  std::array<char, 65536> bytes;
  std::string all;
  for (ssize_t n = ::read(fd, bytes.data(), bytes.size()); n > 0; n = ::read(fd, bytes.data(), bytes.size())) {
    all.append(bytes.data(), static_cast<std::size_t>(n));
  }
  return all;
}

struct Cabled {
  Cabled() : cable(StreamLink::listen(parse_stream_place(folder / "kobuki").value()).value(), clock) {}
  [[nodiscard]] StreamLink host() const { return StreamLink::dial(parse_stream_place(folder / "kobuki").value()); }
  test::TempFolder folder;
  RealClock clock;
  SocketCable cable;
  Device device;
};

}  // namespace

TEST_CASE("bytes go both ways between a socket and a base, as soon as somebody is there") {
  Cabled c;
  CHECK(c.cable.path() == c.folder / "kobuki");
  c.device.to_say = "nobody hears this";
  c.cable.pump(c.device);
  CHECK(c.device.to_say.empty());
  CHECK(c.cable.lost_bytes() == 0);
  StreamLink host = c.host();
  REQUIRE(host.connection(0) >= 0);
  c.cable.pump(c.device);
  CHECK(taken(host.fd()).empty());
  c.device.to_say = "feedback";
  REQUIRE(::send(host.fd(), "command", 7, MSG_NOSIGNAL) == 7);
  c.cable.pump(c.device);
  CHECK(taken(host.fd()) == "feedback");
  CHECK(c.device.heard == "command");
}

TEST_CASE("a host that does not read is told little of what was, once it reads again") {
  Cabled c;
  StreamLink host = c.host();
  REQUIRE(host.connection(0) >= 0);
  std::size_t said = 0;
  for (int i = 0; i < 2000; ++i) {
    c.device.to_say = std::string(80, static_cast<char>('a' + i % 26));
    said += c.device.to_say.size();
    c.cable.pump(c.device);
  }
  const std::string old = taken(host.fd());
  CHECK(old.size() <= 4096);  // of 160000
  CHECK(old.size() % 80 == 0);
  CHECK(c.cable.lost_bytes() == said - old.size());
}

TEST_CASE("the other side may break off and come back, and the cable may be pulled out") {
  Cabled c;
  StreamLink host = c.host();
  REQUIRE(host.connection(0) >= 0);
  c.cable.pump(c.device);
  CHECK(c.cable.is_connected());
  host.hang_up(0);
  c.cable.pump(c.device);
  CHECK_FALSE(c.cable.is_connected());
  REQUIRE(host.connection(1'000'000'000) >= 0);
  c.cable.pump(c.device);
  CHECK(c.cable.connections() == 2);
  c.cable.pull_out();
  CHECK(c.cable.path().empty());
  c.cable.pump(c.device);
  std::array<char, 8> bytes;
  CHECK(::read(host.fd(), bytes.data(), bytes.size()) == 0);
  REQUIRE(c.cable.plug_in().ok());
  host.hang_up(2'000'000'000);
  REQUIRE(host.connection(3'000'000'000) >= 0);
  c.cable.pump(c.device);
  CHECK(c.cable.is_connected());
}

TEST_CASE("a cable that dials finds its host whenever that listens") {
  const test::TempFolder folder;
  RealClock clock;
  SocketCable cable(StreamLink::dial(parse_stream_place(folder / "qemu").value(), {1'000'000, 2'000'000}), clock);
  Device device;
  cable.pump(device);
  CHECK_FALSE(cable.is_connected());
  for (std::uint64_t round = 1; round <= 3; ++round) {
    auto listening = StreamLink::listen(parse_stream_place(folder / "qemu").value());
    REQUIRE(listening.ok());
    for (int i = 0; i < 1000 && !cable.is_connected(); ++i) {
      clock.sleep_until(clock.now() + 5'000'000);
      cable.pump(device);
    }
    CHECK(cable.connections() == round);
    REQUIRE(listening.value().connection(0) >= 0);
    listening.value().hang_up(0);
    cable.pump(device);
    CHECK_FALSE(cable.is_connected());
  }
}
