// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/pty_kobuki.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <filesystem>
#include <vector>

#include "hal/sim/sim_kobuki.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::hal;

namespace {

/// Says a number of bytes, remembers what it hears.
struct Talker final : ByteLine {
  std::size_t read(std::span<std::uint8_t> into) override {
    std::size_t n = 0;
    while (n < into.size() && left > 0) {
      into[n++] = static_cast<std::uint8_t>(said++);
      --left;
    }
    return n;
  }
  bool write(std::span<const std::uint8_t> bytes) override {
    heard.insert(heard.end(), bytes.begin(), bytes.end());
    return true;
  }
  LineState state() const override { return LineState::up; }
  std::size_t left = 0;
  std::size_t said = 0;
  std::vector<std::uint8_t> heard;
};

std::vector<std::uint8_t> read_all(int fd) {
  std::vector<std::uint8_t> got;
  std::array<std::uint8_t, 4096> bytes;
  pollfd ready{fd, POLLIN, 0};
  while (::poll(&ready, 1, 20) > 0) {
    const ssize_t n = ::read(fd, bytes.data(), bytes.size());
    if (n <= 0) break;
    got.insert(got.end(), bytes.begin(), bytes.begin() + n);
  }
  return got;
}

}  // namespace

TEST_CASE("every byte passes both ways unchanged and without echo") {
  auto pty = PtyKobuki::open();
  REQUIRE(pty.ok());
  const int host = ::open(pty.value().path().c_str(), O_RDWR | O_NOCTTY);
  REQUIRE(host >= 0);
  Talker base;
  base.left = 1024;
  pty.value().pump(base);
  const auto got = read_all(host);
  REQUIRE(got.size() == 1024);
  for (std::size_t i = 0; i < got.size(); ++i) REQUIRE(got[i] == static_cast<std::uint8_t>(i));
  std::vector<std::uint8_t> all(256);
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint8_t>(i);
  REQUIRE(::write(host, all.data(), all.size()) == 256);
  for (int i = 0; i < 100 && base.heard.size() < all.size(); ++i) {
    pty.value().pump(base);
    ::usleep(1000);
  }
  CHECK(base.heard == all);
  CHECK(read_all(host).empty());
  CHECK(pty.value().lost_bytes() == 0);
  ::close(host);
}

TEST_CASE("a host that does not read loses bytes, but never blocks the base") {
  auto pty = PtyKobuki::open();
  REQUIRE(pty.ok());
  Talker base;
  base.left = 1 << 20;
  pty.value().pump(base);
  CHECK(base.left == 0);
  CHECK(pty.value().lost_bytes() > (1 << 19));
}

TEST_CASE("a host may close and open again; a pulled cable is noticed, and the link follows the new one") {
  const g3d::test::TempFolder folder;
  const std::string link = folder.path() + "/kobuki";
  auto pty = PtyKobuki::open(link);
  REQUIRE(pty.ok());
  Talker base;
  ::close(::open(link.c_str(), O_RDWR | O_NOCTTY));
  const int host = ::open(link.c_str(), O_RDWR | O_NOCTTY);
  base.left = 3;
  pty.value().pump(base);
  CHECK(read_all(host).size() == 3);
  pty.value().pull_out();
  std::uint8_t byte = 0;
  CHECK(::read(host, &byte, 1) <= 0);
  CHECK(::write(host, &byte, 1) < 0);
  CHECK_FALSE(std::filesystem::exists(link));
  ::close(host);
  pty.value().pump(base);  // nothing happens
  REQUIRE(pty.value().plug_in().ok());
  const int again = ::open(link.c_str(), O_RDWR | O_NOCTTY);
  REQUIRE(again >= 0);
  base.left = 5;
  pty.value().pump(base);
  CHECK(read_all(again).size() == 5);
  ::close(again);
  CHECK(PtyKobuki::open("/nowhere/at/all").error().reason == Reason::io_error);
}
