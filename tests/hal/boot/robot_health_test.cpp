// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/robot_health.hpp"

#include <catch2/catch.hpp>

using namespace g3d::hal;
using namespace g3d::hal::boot;

namespace {
constexpr TimeNs kSecond_ns = 1'000'000'000;
using State = RobotHealth::State;
const Notice kReady = parse_notice("READY=1"), kAlive = parse_notice("WATCHDOG=1"),
             kStopping = parse_notice("STOPPING=1");
}  // namespace

TEST_CASE("a datagram of systemd's notification protocol is read, whatever is in it", "[boot]") {
  const Notice all = parse_notice("READY=1\nWATCHDOG=1\nSTATUS=12 % seen\x1b[2J\nMAINPID=7\n\nSTOPPING=1");
  CHECK(all.is_ready);
  CHECK(all.is_alive);
  CHECK(all.is_stopping);
  CHECK(all.status == "12 % seen?[2J");
  CHECK(all.unknown == 1);
  const Notice none = parse_notice("READY=0\nWATCHDOG=trigger\nREADY=11\nready=1");
  CHECK_FALSE(none.is_ready);
  CHECK_FALSE(none.is_alive);
  CHECK(none.unknown == 4);
  CHECK(parse_notice("STATUS=" + std::string(100'000, 'x')).status.size() <= kMostNotice_bytes);
}

TEST_CASE("the watchdog is fed while the robot starts, and then only while it speaks", "[boot]") {
  RobotHealth health({2 * kSecond_ns, 100 * kSecond_ns, 30 * kSecond_ns});
  CHECK(health.state(0) == State::away);
  CHECK(health.may_feed(0));
  health.on_notice(kReady, 0);  // from nobody
  CHECK(health.state(0) == State::away);

  health.on_start(10 * kSecond_ns);
  CHECK(health.state(110 * kSecond_ns) == State::starting);
  CHECK(health.state(110 * kSecond_ns + 1) == State::overdue);
  CHECK_FALSE(health.may_feed(110 * kSecond_ns + 1));

  health.on_start(200 * kSecond_ns);
  health.on_notice(kReady, 201 * kSecond_ns);
  CHECK(health.state(203 * kSecond_ns) == State::running);
  CHECK(health.state(203 * kSecond_ns + 1) == State::silent);
  CHECK_FALSE(health.may_feed(203 * kSecond_ns + 1));
  health.on_notice(kReady, 203 * kSecond_ns + 2);  // a second one says nothing about its threads
  CHECK(health.state(203 * kSecond_ns + 2) == State::silent);
  health.on_notice(kAlive, 204 * kSecond_ns);
  CHECK(health.state(206 * kSecond_ns) == State::running);
  CHECK(health.may_feed(206 * kSecond_ns));
  health.on_end();
  CHECK(health.may_feed(1000 * kSecond_ns));
}

TEST_CASE("a robot whose threads run is left in peace where there is nothing to map", "[boot]") {
  RobotHealth health({2 * kSecond_ns, 100 * kSecond_ns, 30 * kSecond_ns});
  health.on_start(0);
  for (TimeNs now_ns = kSecond_ns; now_ns < 1000 * kSecond_ns; now_ns += kSecond_ns) {
    health.on_notice(kAlive, now_ns);
    REQUIRE(health.state(now_ns) == State::starting);
    REQUIRE(health.may_feed(now_ns));
  }
  CHECK_FALSE(health.may_feed(1002 * kSecond_ns));  // 999 s was the last
}

TEST_CASE("a robot that ends may take its time to save the map, but not for ever", "[boot]") {
  RobotHealth health({2 * kSecond_ns, 100 * kSecond_ns, 30 * kSecond_ns});
  health.on_start(0);
  health.on_notice(kReady, 1);
  health.on_notice(kStopping, kSecond_ns);
  CHECK(health.state(31 * kSecond_ns) == State::stopping);
  CHECK(health.may_feed(31 * kSecond_ns));
  health.on_notice(kStopping, 20 * kSecond_ns);  // said again: no more time for that
  health.on_notice(kAlive, 20 * kSecond_ns);
  CHECK(health.state(31 * kSecond_ns + 1) == State::overdue);
  CHECK_FALSE(health.may_feed(31 * kSecond_ns + 1));
}
