// SPDX-License-Identifier: Apache-2.0
// Two emulated robots on one cable: link-local addresses, and what each hears of the other over UDP.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "tests/emulated/robot_machine.hpp"

using namespace g3d::test;
using std::chrono::seconds;

namespace {

/// One end of a cable between two machines.
std::vector<std::string> cable(const TempFolder& folder, int own) {
  const auto end = [&](int number) { return fmt::format("{}/cable{}", folder.path(), number); };
  return {"-netdev", fmt::format("dgram,id=net,local.type=unix,local.path={},remote.type=unix,remote.path={}", end(own),
                                 end(3 - own))};
}

bool sees_the_other(Machine& machine) {
  const auto end = std::chrono::steady_clock::now() + kMoveLimit;
  while (std::chrono::steady_clock::now() < end) {
    const std::size_t before = machine.console_size();
    machine.type("tell peers");
    const auto line = machine.await("\"robots\"", seconds(10), before);
    if (line && line->find("\"alive\"") != std::string::npos) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
  return false;
}

}  // namespace

TEST_CASE("two emulated robots on one cable find each other and share what they map", "[emulated][fleet]") {
  if (const std::string missing = no_robot_machine(); !missing.empty()) FAIL(missing);
  const TempFolder folder;
  RobotMachine one("two_rooms", cable(folder, 1), 1), two("two_rooms", cable(folder, 2), 2);
  REQUIRE(run_g3dmap({"key", "--out", folder / "fleet.key"}).exit_code == 0);
  for (RobotMachine* robot : {&one, &two}) {
    put_on_data(robot->disk(), folder / "fleet.key", "fleet.key");
    robot->machine().power_on();
  }
  for (RobotMachine* robot : {&one, &two}) {
    INFO(robot->machine().console());
    REQUIRE(robot->machine().await("network: 169.254.", kBootLimit));
    REQUIRE(robot->machine().await(kMapping, kBootLimit));
  }
  CHECK(sees_the_other(one.machine()));
  CHECK(sees_the_other(two.machine()));
}
