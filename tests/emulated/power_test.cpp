// SPDX-License-Identifier: Apache-2.0
// The plug is pulled at any moment. What the robot had mapped a second before, it still has.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <random>
#include <thread>

#include "tests/emulated/robot_machine.hpp"

using namespace g3d::test;
using std::chrono::seconds;

namespace {

/// The versions that this robot's layers have, as `peers` tells them: added up, as every start may begin another layer.
std::optional<double> known_versions(Machine& machine) {
  // On a busy host it may be too slow to answer once.
  std::optional<std::string> line;
  for (int tries = 0; tries < 5 && !line; ++tries) {
    const std::size_t before = machine.console_size();
    machine.type("tell peers");
    line = machine.await("\"layers\"", seconds(5), before);
  }
  if (!line) return std::nullopt;
  double sum = 0.0;
  for (std::size_t at = 0; (at = line->find("\"upto\":", at)) != std::string::npos; ++at) {
    sum += std::strtod(line->c_str() + at + 7, nullptr);
  }
  return sum;
}

void cut_power_often(int cuts, unsigned seed) {
  if (const std::string missing = no_robot_machine(); !missing.empty()) FAIL(missing);
  RobotMachine robot("two_rooms");
  Machine& machine = robot.machine();
  std::mt19937 random(seed);
  double durable = 0.0;
  for (int cut = 0; cut <= cuts; ++cut) {
    const std::size_t before = machine.console_size();
    machine.power_on();
    REQUIRE(machine.await(kMapping, kBootLimit, before));
    const auto restored = known_versions(machine);
    INFO(machine.console(before));
    REQUIRE(restored);
    fmt::print("start {}: {} versions known, {} had to be\n", cut + 1, *restored, durable);
    REQUIRE(*restored >= durable);
    // A robot that was cut off again and again before it was proven tries its other system, which is empty here.
    CHECK(machine.console(before).find("cannot be mounted at /data") == std::string::npos);
    if (cut == cuts) break;
    // What is known now is on the disk a second of the robot's later; then the plug is pulled at any moment.
    std::this_thread::sleep_for(std::chrono::milliseconds(random() % 3000));
    const auto known = known_versions(machine);
    REQUIRE(known);
    durable = *known;
    std::this_thread::sleep_for(std::chrono::milliseconds(1000 * kSlow + random() % 2000));
    machine.cut_power();
  }
}

}  // namespace

TEST_CASE("power cuts lose no more than the last second of the map", "[emulated][power]") { cut_power_often(3, 1); }

TEST_CASE("twenty power cuts lose no more than the last second of the map each", "[emulated][.soak]") {
  cut_power_often(20, 2);
}
