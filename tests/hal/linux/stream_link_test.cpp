// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/stream_link.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <thread>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using hal::StreamLink;
using hal::StreamPlace;

namespace {

constexpr hal::TimeNs kSecond_ns = 1'000'000'000;

StreamPlace place_at(const std::string& text) { return hal::parse_stream_place(text).value(); }

/// "", if nothing comes within some seconds.
std::string hear(int fd) {
  std::array<char, 64> bytes;
  for (int i = 0; i < 500; ++i) {
    const ssize_t count = ::read(fd, bytes.data(), bytes.size());
    if (count >= 0) return {bytes.data(), static_cast<std::size_t>(count)};
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return {};
}

void say(int fd, const std::string& text) {
  REQUIRE(::send(fd, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size()));
}

}  // namespace

TEST_CASE("places are read as people write them") {
  CHECK(place_at("tcp:127.0.0.1:7000").is_tcp);
  CHECK(place_at("tcp:127.0.0.1:7000").endpoint.port == 7000);
  CHECK(place_at("unix:run/a.sock").path == "run/a.sock");
  CHECK(place_at("/dev/virtio-ports/camera").path == "/dev/virtio-ports/camera");
  CHECK(hal::to_string(place_at("tcp:127.0.0.1:7000")) == "tcp:127.0.0.1:7000");
  CHECK(hal::to_string(place_at("unix:/run/a")) == "/run/a");
  for (const char* const text :
       {"", "a", "unix:", "unix:a", "tcp:", "tcp:localhost:70", "tcp:1.2.3.4", "tcp:1.2.3.4:0"}) {
    INFO(text);
    const auto place = hal::parse_stream_place(text);
    REQUIRE_FALSE(place.ok());
    CHECK(place.error().reason == hal::Reason::bad_usage);
    CHECK(place.error().text.find("tcp:ADDRESS:PORT") != std::string::npos);
  }
  CHECK_FALSE(hal::parse_stream_place("/" + std::string(200, 'x')).ok());
}

TEST_CASE("whoever comes last has the stream, and one that dials comes back after a break") {
  const test::TempFolder folder;
  auto listening = StreamLink::listen(place_at(folder / "s"));
  REQUIRE(listening.ok());
  StreamLink& server = listening.value();
  CHECK(server.connection(0) == -1);
  StreamLink first = StreamLink::dial(place_at(folder / "s"));
  REQUIRE(first.connection(0) >= 0);
  REQUIRE(server.connection(0) >= 0);
  say(server.fd(), "one");
  CHECK(hear(first.fd()) == "one");

  StreamLink second = StreamLink::dial(place_at(folder / "s"));
  REQUIRE(second.connection(0) >= 0);
  REQUIRE(server.connection(0) >= 0);
  CHECK(server.connections() == 2);
  say(server.fd(), "two");
  CHECK(hear(second.fd()) == "two");
  CHECK(hear(first.fd()).empty());  // its end

  first.hang_up(kSecond_ns);
  CHECK(first.fd() == -1);
  CHECK(first.connection(kSecond_ns) == -1);  // not at once
  CHECK(first.connection(2 * kSecond_ns) >= 0);
  CHECK(first.connections() == 2);
}

TEST_CASE("tries in vain come with growing pauses, and succeed once somebody listens") {
  const test::TempFolder folder;
  StreamLink link = StreamLink::dial(place_at(folder / "s"), {kSecond_ns, 4 * kSecond_ns});
  CHECK(link.connection(0) == -1);
  CHECK(link.last_errno() == ENOENT);
  int tries = 0;
  for (hal::TimeNs now = 0; now <= 20 * kSecond_ns; now += kSecond_ns / 10) {
    test::write_plain(folder / "s", "no socket");
    (void)link.connection(now);
    tries += link.last_errno() == ENOTSOCK;
    ::unlink((folder / "s").c_str());
    (void)link.connection(now);
  }
  CHECK(link.connections() == 0);
  CHECK(tries > 0);
  const auto server = StreamLink::listen(place_at(folder / "s"));
  REQUIRE(server.ok());
  CHECK(link.connection(100 * kSecond_ns) >= 0);
  CHECK(link.last_errno() == 0);
}

TEST_CASE("a place that is taken is refused, and what a killed program left is replaced") {
  const test::TempFolder folder;
  const std::string path = folder / "s";
  {
    const auto server = StreamLink::listen(place_at(path));
    REQUIRE(server.ok());
    const auto other = StreamLink::listen(place_at(path));
    REQUIRE_FALSE(other.ok());
    CHECK(other.error().reason == hal::Reason::no_capacity);
    CHECK(other.error().text.find(path) == 0);
  }
  CHECK(::access(path.c_str(), F_OK) != 0);
  test::write_plain(path, "a file of somebody");
  CHECK_FALSE(StreamLink::listen(place_at(path)).ok());
  CHECK(test::read_plain(path) == "a file of somebody");
}

TEST_CASE("streams go by TCP and out of pipes as well") {
  StreamPlace any;
  any.is_tcp = true;
  any.endpoint = {0x7F000001, 0};
  auto server = StreamLink::listen(any);
  REQUIRE(server.ok());
  CHECK(server.value().place().endpoint.port != 0);
  StreamLink client = StreamLink::dial(server.value().place());
  REQUIRE(client.connection(0) >= 0);
  for (int i = 0; i < 500 && server.value().connection(0) < 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  REQUIRE(server.value().fd() >= 0);
  say(server.value().fd(), "by tcp");
  CHECK(hear(client.fd()) == "by tcp");

  const test::TempFolder folder;
  REQUIRE(::mkfifo((folder / "p").c_str(), 0600) == 0);
  StreamLink pipe = StreamLink::dial(place_at(folder / "p"));
  CHECK(pipe.connection(0) >= 0);
  CHECK(hear(pipe.fd()).empty());  // nobody writes
}
