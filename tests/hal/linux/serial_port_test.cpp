// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/serial_port.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <termios.h>
#include <unistd.h>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/support/pty_pair.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using hal::DataClock;
using hal::LineState;
using hal::Reason;
using hal::Result;
using hal::SerialPort;
using test::PtyPair;

namespace {

using Bytes = std::vector<std::uint8_t>;

SerialPort::Options at(const std::string& path) {
  return {[path]() -> Result<std::string> { return path; }, {}, 100'000'000};
}

Bytes read_some(SerialPort& port) {
  Bytes bytes(64);
  bytes.resize(port.read(bytes));
  return bytes;
}

}  // namespace

TEST_CASE("All byte values pass in both directions, unchanged") {
  PtyPair pty;
  const DataClock clock;
  SerialPort port(at(pty.path()), clock);
  REQUIRE(port.open().ok());
  CHECK(port.state() == LineState::up);
  Bytes all(256);
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint8_t>(i);
  CHECK(port.read(all) == 0);  // nothing there is not a loss
  CHECK(port.state() == LineState::up);

  REQUIRE(port.write(all));
  CHECK(pty.read_all(256) == all);
  pty.write(all);
  Bytes got;
  while (got.size() < 256) {
    const Bytes more = read_some(port);
    if (more.empty()) break;
    got.insert(got.end(), more.begin(), more.end());
  }
  CHECK(got == all);
}

TEST_CASE("The line is raw, 115200 8N1, without flow control") {
  PtyPair pty;
  const DataClock clock;
  SerialPort port(at(pty.path()), clock);
  REQUIRE(port.open().ok());
  termios t{};
  REQUIRE(::tcgetattr(port.fd(), &t) == 0);
  CHECK(::cfgetispeed(&t) == B115200);
  CHECK(::cfgetospeed(&t) == B115200);
  CHECK((t.c_cflag & CSIZE) == CS8);
  CHECK((t.c_cflag & (PARENB | CSTOPB | CRTSCTS)) == 0);
  CHECK((t.c_cflag & (CLOCAL | CREAD)) == (CLOCAL | CREAD));
  CHECK((t.c_lflag & (ICANON | ECHO | ISIG)) == 0);
  CHECK((t.c_iflag & (IXON | IXOFF | ICRNL)) == 0);
  CHECK((t.c_oflag & OPOST) == 0);
  // A pseudo-terminal has no adapter that could be asked; it must be said.
  CHECK(port.low_latency() == hal::LowLatency::refused);
  CHECK(std::string(to_string(port.low_latency())) == "refused");
}

TEST_CASE("Two processes cannot drive one base") {
  PtyPair pty;
  const DataClock clock;
  SerialPort first(at(pty.path()), clock);
  SerialPort second(at(pty.path()), clock);
  REQUIRE(first.open().ok());
  const auto refused = second.open();
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().reason == Reason::no_capacity);
  first.close();
  CHECK(second.open().ok());
}

TEST_CASE("What cannot be opened says why and what to do") {
  test::TempFolder folder;
  const DataClock clock;
  SerialPort none(at(folder / "ttyUSB0"), clock);
  const auto missing = none.open();
  REQUIRE_FALSE(missing.ok());
  CHECK(missing.error().reason == Reason::not_found);
  CHECK(missing.error().text.find("ttyUSB0") != std::string::npos);
  test::write_plain(folder / "file", "x");
  SerialPort file(at(folder / "file"), clock);
  CHECK(file.open().error().reason == Reason::unsupported);
  CHECK(file.state() == LineState::lost);
  CHECK_FALSE(file.write(Bytes{1}));
  SerialPort lost(
      [] {
        SerialPort::Options options;
        options.find = []() -> Result<std::string> { return hal::Error{Reason::not_found, "nobody there"}; };
        return options;
      }(),
      clock);
  CHECK(lost.open().error().text == "nobody there");
}

TEST_CASE("Unplugged is seen at once; plugged in again under another name it comes back within the retry time") {
  auto pty = std::make_unique<PtyPair>();
  std::string where = pty->path();
  std::vector<int> opened;
  DataClock clock;
  SerialPort::Options options;
  options.find = [&]() -> Result<std::string> { return where; };
  options.on_open = [&](int fd) { opened.push_back(fd); };
  SerialPort port(options, clock);
  REQUIRE(port.open().ok());
  pty.reset();
  where = "/nonexistent/port";
  CHECK(read_some(port).empty());
  CHECK(port.state() == LineState::lost);
  CHECK_FALSE(port.write(Bytes{1, 2, 3}));
  for (int i = 0; i < 20; ++i) {
    clock.advance_to(clock.now() + 20'000'000);
    CHECK(read_some(port).empty());
  }
  PtyPair again;
  where = again.path();
  again.write(Bytes{7});  // sent before we listened: of unknown age, dropped
  clock.advance_to(clock.now() + 100'000'000);
  CHECK(read_some(port).empty());
  CHECK(port.state() == LineState::up);
  CHECK(port.path() == again.path());
  CHECK(opened.size() == 2);
  again.write(Bytes{8, 9});
  CHECK(read_some(port) == Bytes{8, 9});
}

TEST_CASE("While lost, the port is not looked for at every read") {
  int asked = 0;
  DataClock clock;
  SerialPort::Options options;
  options.find = [&]() -> Result<std::string> {
    ++asked;
    return hal::Error{Reason::not_found, ""};
  };
  SerialPort port(options, clock);
  for (int i = 0; i < 100; ++i) {  // two seconds
    clock.advance_to(clock.now() + 20'000'000);
    CHECK(read_some(port).empty());
  }
  CHECK(asked >= 19);
  CHECK(asked <= 21);
}

TEST_CASE("A closed port stays closed") {
  PtyPair pty;
  DataClock clock;
  SerialPort port(at(pty.path()), clock);
  REQUIRE(port.open().ok());
  port.close();
  clock.advance_to(10'000'000'000);
  CHECK(read_some(port).empty());
  CHECK(port.state() == LineState::lost);
  CHECK(port.opened() == 1);
}

TEST_CASE("A reader that stopped does not make the writer wait") {
  PtyPair pty;
  const DataClock clock;
  SerialPort port(at(pty.path()), clock);
  REQUIRE(port.open().ok());
  const Bytes packet(10, 0x55);
  int taken = 0;
  for (int i = 0; i < 20'000; ++i) taken += port.write(packet);
  CHECK(taken < 20'000);
  CHECK(port.refused_writes() == static_cast<std::uint64_t>(20'000 - taken));
  CHECK(port.state() == LineState::up);
}
