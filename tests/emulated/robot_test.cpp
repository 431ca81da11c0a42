// SPDX-License-Identifier: Apache-2.0
// The whole robot from the power switch on: U-Boot, extlinux, our image, our first process, the kernel's own driver of
// the base's USB adapter, and the program for 64-bit Arm; all that is not real is the silicon.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <thread>

#include "tests/emulated/robot_machine.hpp"

using namespace g3d::test;
using std::chrono::seconds;

TEST_CASE("an emulated robot boots, drives, stands without its base, and comes back after its watchdog",
          "[emulated][core]") {
  if (const std::string missing = no_robot_machine(); !missing.empty()) FAIL(missing);
  RobotMachine robot("two_rooms");
  Machine& machine = robot.machine();
  const auto power_on = std::chrono::steady_clock::now();
  machine.power_on();
  const auto first = machine.await(kMapping, kBootLimit);
  INFO(machine.console());
  REQUIRE(first);
  const double boot_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - power_on).count();
  // Printed for RESULTS.md; the guest's second is as long as the host gives it time.
  fmt::print("first frame integrated {:.1f} s after the kernel began, {:.1f} s after the power switch\n",
             guest_time_s(*first), boot_s);
  CHECK(machine.console().find("U-Boot") != std::string::npos);
  CHECK(machine.console().find("is the first process") != std::string::npos);
  CHECK(machine.console().find("system a") != std::string::npos);

  REQUIRE(robot.moves_within(kMoveLimit));
  REQUIRE(machine.unplug_base());
  // What a base that was told to drive does without a line is the base's business; that it is told zero at once when
  // the line is back, and that it goes on then, is ours.
  std::this_thread::sleep_for(seconds(3));
  REQUIRE(machine.plug_base());
  CHECK(robot.moves_within(kMoveLimit));

  const std::size_t before = machine.console_size();
  machine.type("hang mapper");
  REQUIRE(machine.await("hangs", kMoveLimit, before));
  REQUIRE(machine.await("not fed any more", kMoveLimit, before));
  REQUIRE(robot.stands_within(kMoveLimit));
  REQUIRE(machine.await("is the first process", kBootLimit, before));
  const auto again = machine.await(kMapping, kBootLimit, before);
  REQUIRE(again);
  CHECK(robot.moves_within(kMoveLimit));

  const std::size_t last = machine.console_size();
  machine.type("poweroff");
  CHECK(machine.await("is switched off", kMoveLimit, last));
}
