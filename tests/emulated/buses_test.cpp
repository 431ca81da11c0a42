// SPDX-License-Identifier: Apache-2.0
// The emergency stops of an emulated robot: a line of the board's GPIO chip, and a node on its CAN bus.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <optional>
#include <thread>
#include <vector>

#include "tests/emulated/robot_machine.hpp"

using namespace g3d::test;
using std::chrono::seconds;

namespace {

// Line 3 of the chip (pl061) is low, and high for 0.1 s when the board's power key is pressed: like a wire that breaks.
constexpr const char* kBoard = R"(
[can]
interface = "vcan0"
estop_node = 17
estop_heartbeat_ms = 2000

[gpio]
chip = "gpiochip0"
estop = "3"
estop_closed = "low"
)";

/// From the edge at the chip to the zero at the base's end of the line; nothing, if it had not been told to drive.
std::optional<double> stop_ms(RobotMachine& robot) {
  const auto begin = std::chrono::steady_clock::now();
  const auto waited_ms = [&] {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  };
  while (robot.told_mmps() == 0.0) {
    if (waited_ms() > 60e3) return std::nullopt;
  }
  const double driven_ms = waited_ms();
  if (!robot.machine().pulse_gpio()) return std::nullopt;
  while (robot.told_mmps() != 0.0) {
    if (waited_ms() > 120e3) return std::nullopt;
  }
  return waited_ms() - driven_ms;
}

}  // namespace

TEST_CASE("an emulated robot stops for its GPIO line, for an EMCY, and for a heartbeat that is lost",
          "[emulated][buses]") {
  if (const std::string missing = no_robot_machine(); !missing.empty()) FAIL(missing);
  const TempFolder folder;
  RobotMachine robot("two_rooms");
  write_plain(folder / "board.toml", read_plain("board/emulated.toml") + kBoard);
  put_on_data(robot.disk(), folder / "board.toml", "board.toml");
  std::string init = read_plain("tests/emulated/init.toml");
  const std::string system_board = "/system/board.toml";
  init.replace(init.find(system_board), system_board.size(), "/data/board.toml");
  write_plain(folder / "init.toml", init);
  put_on_data(robot.disk(), folder / "init.toml", "init.toml");

  Machine& machine = robot.machine();
  machine.power_on();
  REQUIRE(machine.await(kMapping, kBootLimit));
  // A node that was never heard: it stands until it is.
  CHECK(robot.stands_within(kMoveLimit));
  machine.type("run buses --play-node vcan0:17");
  REQUIRE(robot.moves_within(kMoveLimit));

  machine.type("type press");
  CHECK(robot.stands_within(kMoveLimit));
  machine.type("type release");
  machine.type("tell resume");
  REQUIRE(robot.moves_within(kMoveLimit));

  REQUIRE(machine.pulse_gpio());
  CHECK(robot.stands_within(kMoveLimit));
  machine.type("tell resume");
  REQUIRE(robot.moves_within(kMoveLimit));

  // Printed for RESULTS.md: how fast it is here says how fast the emulator is. A look takes some milliseconds.
  std::vector<double> stops_ms;
  for (int i = 0; i < 9; ++i) {
    const auto ms = stop_ms(robot);
    REQUIRE(ms);
    stops_ms.push_back(*ms);
    std::this_thread::sleep_for(seconds(2));
    machine.type("tell resume");
  }
  std::sort(stops_ms.begin(), stops_ms.end());
  fmt::print("GPIO edge to zero at the base: {:.0f}/{:.0f}/{:.0f} ms, min/median/max of {}\n", stops_ms.front(),
             stops_ms[stops_ms.size() / 2], stops_ms.back(), stops_ms.size());
  REQUIRE(robot.moves_within(kMoveLimit));

  machine.type("end");  // the node dies without a word
  CHECK(robot.stands_within(kMoveLimit));
  const std::size_t before = machine.console_size();
  machine.type("tell buses");
  const auto counts = machine.await("heartbeat", seconds(20), before);
  REQUIRE(counts);
  INFO(*counts);
  CHECK(machine.is_on());
}
