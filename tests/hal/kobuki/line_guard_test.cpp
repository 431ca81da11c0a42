// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/line_guard.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "hal/clock.hpp"
#include "hal/linux/serial_port.hpp"
#include "tests/support/command_tap.hpp"
#include "tests/support/pty_pair.hpp"

using namespace g3d;
using namespace g3d::hal::kobuki;
using hal::RealClock;
using hal::TimeNs;
using test::CommandTap;
using test::PtyPair;
using test::SentPacket;

namespace {

constexpr TimeNs kMs = 1'000'000;
constexpr std::array<std::uint8_t, 10> kForward = {0xaa, 0x55, 0x06, 0x01, 0x04, 0xc8, 0, 0, 0, 0xcb};

int open_port(const PtyPair& pty) {
  const int fd = ::open(pty.path().c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0 || !hal::set_raw_115200(fd)) std::abort();
  return fd;
}

void pause_ms(int ms) {
  RealClock clock;
  clock.sleep_until(clock.now() + ms * kMs);
}

/// A main process of its own that drives forward until `end_after_ms`, then ends as `end` says; -1: drives for ever.
pid_t fork_driver(const PtyPair& pty, int end_after_ms, const std::function<void()>& end) {
  const pid_t process = ::fork();
  if (process < 0) std::abort();
  if (process != 0) return process;
  {
    const int fd = open_port(pty);
    auto guard = LineGuard::start(fd);
    if (!guard.ok()) ::_exit(3);
    for (int t_ms = 0; end_after_ms < 0 || t_ms < end_after_ms; t_ms += 20) {
      guard.value().beat();
      if (::write(fd, kForward.data(), kForward.size()) != static_cast<ssize_t>(kForward.size())) ::_exit(4);
      pause_ms(20);
    }
    end();
  }
  ::_exit(0);
}

std::size_t count_zeros(const std::vector<SentPacket>& packets) {
  std::size_t zeros = 0;
  for (const SentPacket& p : packets) zeros += p.is_zero_speed();
  return zeros;
}

/// -1 would mean every process there is.
void signal_process(pid_t process, int signal) {
  if (process <= 1) FAIL("no process to signal");
  ::kill(process, signal);
}

void end_process(pid_t process) {
  signal_process(process, SIGKILL);
  ::waitpid(process, nullptr, 0);
}

}  // namespace

TEST_CASE("The zero packet is the one of the protocol") {
  std::uint8_t check = 0;
  for (std::size_t i = 2; i < kZeroSpeedPacket.size(); ++i) check ^= kZeroSpeedPacket[i];
  CHECK(check == 0);
  CHECK(kZeroSpeedPacket[2] == kZeroSpeedPacket.size() - 4);
}

TEST_CASE("While the heart beats, the guard says nothing", "[threads]") {
  const PtyPair pty;
  CommandTap tap(pty.fd());
  const pid_t driver = fork_driver(pty, -1, [] {});
  REQUIRE(tap.wait_for_motion(2'000 * kMs) != 0);
  const auto packets = tap.listen(600 * kMs);
  CHECK(packets.size() >= 10);
  CHECK(count_zeros(packets) == 0);
  end_process(driver);
}

TEST_CASE("Killed: at least five zeros within 500 ms, and then the guard goes", "[threads]") {
  const PtyPair pty;
  CommandTap tap(pty.fd());
  const pid_t driver = fork_driver(pty, -1, [] {});
  REQUIRE(tap.wait_for_motion(2'000 * kMs) != 0);
  end_process(driver);
  const auto packets = tap.listen(500 * kMs);
  CHECK(count_zeros(packets) >= 5);
  REQUIRE_FALSE(packets.empty());
  CHECK(packets.back().is_zero_speed());
  const auto rest = tap.listen(1'500 * kMs);
  CHECK(count_zeros(rest) == rest.size());
  CHECK(count_zeros(packets) + count_zeros(rest) == 50);
}

TEST_CASE("Stopped: zeros within 500 ms and until it goes on", "[threads]") {
  const PtyPair pty;
  CommandTap tap(pty.fd());
  const pid_t driver = fork_driver(pty, -1, [] {});
  REQUIRE(tap.wait_for_motion(2'000 * kMs) != 0);
  signal_process(driver, SIGSTOP);
  CHECK(count_zeros(tap.listen(500 * kMs)) >= 5);
  const auto later = tap.listen(1'000 * kMs);
  CHECK(count_zeros(later) >= 25);
  CHECK(count_zeros(later) == later.size());
  signal_process(driver, SIGCONT);
  CHECK(tap.wait_for_motion(500 * kMs) != 0);
  pause_ms(60);
  tap.drain();
  CHECK(count_zeros(tap.listen(300 * kMs)) == 0);
  end_process(driver);
}

TEST_CASE("Every way out of the main process ends with zeros", "[threads]") {
  struct Way {
    std::string name;
    std::function<void()> end;
  };
  const std::vector<Way> ways = {
      {"return", [] {}},
      {"_exit", [] { ::_exit(1); }},
      {"abort",
       [] {
         ::signal(SIGABRT, SIG_DFL);
         std::abort();
       }},
      {"SIGTERM",
       [] {
         ::signal(SIGTERM, SIG_DFL);
         ::raise(SIGTERM);
       }},
      {"SIGINT",
       [] {
         ::signal(SIGINT, SIG_DFL);
         ::raise(SIGINT);
       }},
      {"SIGSEGV",
       [] {
         ::signal(SIGSEGV, SIG_DFL);
         ::raise(SIGSEGV);
       }},
      {"whole group",
       [] {
         if (::setpgid(0, 0) != 0 || ::getpgrp() != ::getpid()) return;
         ::signal(SIGHUP, SIG_DFL);
         ::kill(0, SIGHUP);
       }},
      {"endless loop",
       [] {
         for (;;) pause_ms(1000);
       }},
  };
  for (const Way& way : ways) {
    INFO(way.name);
    const PtyPair pty;
    CommandTap tap(pty.fd());
    const pid_t driver = fork_driver(pty, 60, way.end);
    REQUIRE(tap.wait_for_motion(2'000 * kMs) != 0);
    CHECK(tap.wait_for_zero(1'000 * kMs) != 0);
    CHECK(count_zeros(tap.listen(300 * kMs)) >= 4);
    end_process(driver);
  }
}

TEST_CASE("A good end: the guard sends its five zeros and is gone when the destructor returns", "[threads]") {
  const PtyPair pty;
  CommandTap tap(pty.fd());
  const int fd = open_port(pty);
  pid_t process = -1;
  {
    auto guard = LineGuard::start(fd);
    REQUIRE(guard.ok());
    CHECK(guard.value().alive());
    process = guard.value().process();
    for (int i = 0; i < 10; ++i) {
      guard.value().beat();
      pause_ms(20);
    }
    CHECK(guard.value().zeros_sent() == 0);
  }
  REQUIRE(process > 1);
  CHECK(::kill(process, 0) != 0);
  const auto packets = tap.listen(50 * kMs);
  CHECK(packets.size() == 5);
  CHECK(count_zeros(packets) == 5);
  ::close(fd);
}

TEST_CASE("A line that came later, or again, is the one that is guarded", "[threads]") {
  auto first = std::make_unique<PtyPair>();
  const PtyPair second;
  CommandTap tap(second.fd());
  auto guard = LineGuard::start(-1);
  REQUIRE(guard.ok());
  int fd = open_port(*first);
  CHECK(guard.value().hand_over(fd));
  CommandTap first_tap(first->fd());
  CHECK(first_tap.wait_for_zero(600 * kMs) != 0);  // no beat so far
  ::close(fd);
  first.reset();  // unplugged
  pause_ms(100);
  CHECK(guard.value().alive());
  fd = open_port(second);
  CHECK(guard.value().hand_over(fd));
  CHECK(tap.wait_for_zero(600 * kMs) != 0);
  CHECK_FALSE(guard.value().hand_over(-1));
  ::close(fd);
}

TEST_CASE("A guard that was killed is noticed", "[threads]") {
  const PtyPair pty;
  const int fd = open_port(pty);
  auto guard = LineGuard::start(fd);
  REQUIRE(guard.ok());
  const pid_t process = guard.value().process();
  signal_process(process, SIGTERM);  // not even that ends it, from its first moment on
  pause_ms(50);
  REQUIRE(guard.value().alive());
  signal_process(process, SIGKILL);
  // The kernel takes its time to end a process that has much address space, as under a sanitizer.
  for (int i = 0; i < 60 && guard.value().alive(); ++i) pause_ms(50);
  CHECK_FALSE(guard.value().alive());
  guard.value().beat();
  CHECK_FALSE(guard.value().hand_over(fd));
  ::close(fd);
}

TEST_CASE("Killed while another child of the process lives on: the guard sees it all the same", "[threads]") {
  const PtyPair pty;
  CommandTap tap(pty.fd());
  std::array<int, 2> pipe_fds{};
  REQUIRE(::pipe(pipe_fds.data()) == 0);
  const pid_t driver = fork_driver(pty, 40, [&] {
    const pid_t other = ::fork();  // holds all that the driver has open
    if (other == 0) {
      pause_ms(4'000);
      ::_exit(0);
    }
    (void)!::write(pipe_fds[1], &other, sizeof other);
    for (;;) pause_ms(1'000);
  });
  pid_t other = -1;
  REQUIRE(::read(pipe_fds[0], &other, sizeof other) == sizeof other);
  end_process(driver);
  CHECK(tap.wait_for_zero(500 * kMs) != 0);
  const auto rest = tap.listen(2'000 * kMs);
  CHECK(count_zeros(rest) >= 49);
  CHECK(tap.listen(200 * kMs).empty());  // and gone
  signal_process(other, SIGKILL);
  for (const int fd : pipe_fds) ::close(fd);
}

TEST_CASE("The guard keeps none of the other descriptors", "[threads]") {
  const PtyPair pty;
  const int fd = open_port(pty);
  std::array<int, 2> pipe_fds{};
  REQUIRE(::pipe(pipe_fds.data()) == 0);
  auto guard = LineGuard::start(fd);
  REQUIRE(guard.ok());
  pause_ms(50);
  ::close(pipe_fds[1]);
  char byte = 0;
  CHECK(::fcntl(pipe_fds[0], F_SETFL, O_NONBLOCK) == 0);
  CHECK(::read(pipe_fds[0], &byte, 1) == 0);  // end of file: nobody else holds the writing end
  ::close(pipe_fds[0]);
  ::close(fd);
}
