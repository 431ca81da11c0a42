// SPDX-License-Identifier: Apache-2.0
// `g3dmap building` and robots in it that are programs of their own, at the serial line and the camera's stream that it
// serves; what it tells of them from outside.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "hal/linux/control_socket.hpp"
#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::test;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

bool happens(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(90);
  while (!condition()) {
    if (std::chrono::steady_clock::now() >= end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return true;
}

/// The `nth` of that name, from 0; nothing if there are not so many.
std::optional<double> number_of(const std::string& json, const std::string& name, int nth = 0) {
  std::size_t at = 0;
  const std::string key = "\"" + name + "\": ";
  for (int i = 0; i <= nth; ++i) {
    at = json.find(key, i == 0 ? 0 : at + 1);
    if (at == std::string::npos) return std::nullopt;
  }
  return std::stod(json.substr(at + key.size(), 32));
}

struct ServedBuilding {
  explicit ServedBuilding(const std::vector<std::string>& more) {
    std::vector<std::string> all{"building", "--world", "two_rooms", "--camera", "80x60@5", "--quiet", "--at", at()};
    all.insert(all.end(), more.begin(), more.end());
    building.emplace(g3dmap_path(), all);
    REQUIRE(happens([&] { return !truth().empty(); }));
  }
  [[nodiscard]] std::string at() const { return folder / "place"; }
  [[nodiscard]] std::string truth() const {
    const auto answer = hal::ask_control_socket(at() + "/control", "status");
    return answer.ok() ? answer.value() : std::string{};
  }
  /// 0 is the first robot.
  [[nodiscard]] double driven_m(int robot) const { return number_of(truth(), "driven_m", robot).value_or(-1.0); }
  [[nodiscard]] std::string out(int robot) const { return folder / ("out" + std::to_string(robot + 1)); }
  [[nodiscard]] std::vector<std::string> robot(int number, const std::vector<std::string>& more,
                                               const std::string& network = {}) const {
    const std::string stem = at() + "/robot" + std::to_string(number + 1);
    const std::string board = folder / ("robot" + std::to_string(number + 1) + ".toml");
    write_plain(board, "name = \"guest\"\n[base]\nline = \"" + stem + ".base\"\n[camera]\nsource = \"stream:" + stem +
                           ".frames\"\n[map]\nresolution_m = 0.1\nthreads = 1\nmemory_mb = 64\n" + network);
    std::vector<std::string> all{"run", "--board", board, "--camera", "80x60@5", "--quiet", "--out", out(number)};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  TempFolder folder;
  std::optional<Program> building;
};

}  // namespace

TEST_CASE("a robot in a building of another program drives, stands at its end, and the truth is told",
          "[system][building][waits]") {
  ServedBuilding served({});
  Program robot(g3dmap_path(), served.robot(0, {}));
  CHECK(happens([&] { return served.driven_m(0) > 0.3; }));
  robot.send(SIGINT);
  const ProgramResult result = robot.finish(std::chrono::seconds(60));
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const std::string report = served.out(0) + "/report.json";
  CHECK(report_is_balanced(report));
  CHECK(report_number(report, "integrated") > 3);
  CHECK(report_number(report, "images") >= report_number(report, "integrated"));
  CHECK(report_number(report, "connections") == 1);
  CHECK(report_number(report, "rejected_packets") == 0);
  CHECK(report_number(report, "skipped_bytes") == 0);

  CHECK(happens([&] { return contains(served.truth(), "\"connected\": false"); }));  // the camera's stream
  const std::string truth = served.truth();
  CHECK(number_of(truth, "told_mmps") == 0.0);
  CHECK(number_of(truth, "coverage").value_or(0.0) > 0.02);
  CHECK(number_of(truth, "collisions") == 0.0);
  const auto stopped = hal::ask_control_socket(served.at() + "/control", "stop");
  REQUIRE(stopped.ok());
  const ProgramResult end = served.building->finish(std::chrono::seconds(60));
  INFO(end.err);
  CHECK(end.exit_code == 0);
  CHECK(contains(read_plain(served.at() + "/truth.json"), "\"drive_commands\": "));
  CHECK_FALSE(std::filesystem::exists(served.at() + "/control"));
  CHECK_FALSE(std::filesystem::exists(served.at() + "/robot1.frames"));
}

TEST_CASE("a robot that is killed is followed by another one in the same building", "[system][building][waits]") {
  ServedBuilding served({});
  {
    Program robot(g3dmap_path(), served.robot(0, {}));
    CHECK(happens([&] { return served.driven_m(0) > 0.2; }));
    robot.send(SIGKILL);
  }
  CHECK(happens([&] { return number_of(served.truth(), "told_mmps") == 0.0; }));  // its guard said so
  const double before_m = served.driven_m(0);
  // As long as the guard of the dead one says zero, the line is its own.
  std::optional<Program> robot;
  CHECK(happens([&] {
    if (!robot || !robot->is_running()) robot.emplace(g3dmap_path(), served.robot(0, {}));
    return served.driven_m(0) > before_m + 0.2;
  }));
  robot->send(SIGINT);
  CHECK(robot->finish(std::chrono::seconds(60)).exit_code == 0);
  CHECK(number_of(served.truth(), "connections", 1) >= 2.0);
}

TEST_CASE("in a slow building a robot with a clock as slow lives as in a quick one", "[system][building][waits]") {
  ServedBuilding served({"--slow", "2"});
  Program robot(g3dmap_path(), served.robot(0, {"--slow", "2"}));
  CHECK(happens([&] { return served.driven_m(0) > 0.2; }));
  robot.send(SIGINT);
  const ProgramResult result = robot.finish(std::chrono::seconds(60));
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(report_number(served.out(0) + "/report.json", "rejected_packets") == 0);
  CHECK(contains(served.truth(), "\"slow\": 2,"));
  CHECK_FALSE(contains(read_plain(served.out(0) + "/report.json"), "times slow"));
}

TEST_CASE("two robots in one building are two programs that share a map by UDP, and both can be replayed",
          "[system][building][fleet][waits]") {
  // They look at each other.
  ServedBuilding served({"--start=-2.4,-0.4,0", "--start=-1.2,-0.4,180", "--robots", "2"});
  REQUIRE(run_g3dmap({"key", "--out", served.folder / "fleet.key"}).exit_code == 0);
  const int first_port = 21'002 + static_cast<int>(::getpid() % 8000) * 4;
  const std::string truth = served.truth();
  const auto log = [&](int number) { return served.folder / ("log" + std::to_string(number + 1)); };
  const auto member = [&](int number) {
    // Its map begins where it stands: the fleet's world is the building's.
    const std::string network = "[network]\ngroup = \"none\"\nbandwidth_kBps = 4000\nx_m = " +
                                std::to_string(*number_of(truth, "x_m", 2 * number)) +
                                "\ny_m = " + std::to_string(*number_of(truth, "y_m", 2 * number)) +
                                "\nyaw_deg = " + std::to_string(*number_of(truth, "heading_deg", 2 * number)) + "\n";
    return served.robot(
        number,
        {"--key", served.folder / "fleet.key", "--robot", "b" + std::to_string(number + 1), "--port",
         std::to_string(first_port + number), "--peer", "127.0.0.1:" + std::to_string(first_port + 1 - number),
         "--settle", "30", "--record", log(number)},
        network);
  };
  Program one(g3dmap_path(), member(0));
  Program two(g3dmap_path(), member(1));
  CHECK(happens([&] { return served.driven_m(0) > 0.3 && served.driven_m(1) > 0.3; }));
  CHECK(happens([&] {
    const auto peers = hal::ask_control_socket(served.out(0) + "/control", "peers");
    return peers.ok() && contains(peers.value(), "\"id\": \"00000000000000b2\"");
  }));
  one.send(SIGINT);
  two.send(SIGINT);
  for (Program* robot : {&one, &two}) {
    const ProgramResult result = robot->finish(std::chrono::seconds(90));
    INFO(result.err);
    CHECK(result.exit_code == 0);
  }
  const std::string hash = report_text(served.out(0) + "/report.json", "merged_hash");
  CHECK(report_text(served.out(1) + "/report.json", "merged_hash") == hash);
  CHECK(report_text(served.out(0) + "/report.json", "hash") != hash);
  for (const int robot : {0, 1}) {
    CHECK(number_of(served.truth(), "collisions_robots", robot) == 0.0);
    // What each took out of its frames because the other stood there is in its recording.
    const std::string report = served.out(robot) + "/report.json";
    CHECK(report_number(report, "masked") > 0);
    const std::string again = served.folder / ("again" + std::to_string(robot));
    CHECK(run_g3dmap({"replay", log(robot), "--out", again, "--quiet"}).exit_code == 0);
    CHECK(report_text(again + "/report.json", "hash") == report_text(report, "hash"));
  }
}

TEST_CASE("what is wrong with a building is said before it begins", "[system][building][waits]") {
  const TempFolder folder;
  const auto expect = [&](const std::vector<std::string>& more, int exit_code, const std::string& says) {
    std::vector<std::string> all{"building", "--quiet", "--duration", "0.1", "--world", "two_rooms"};
    all.insert(all.end(), more.begin(), more.end());
    const ProgramResult result = run_g3dmap(all);
    INFO(result.err);
    CHECK(result.exit_code == exit_code);
    CHECK(contains(result.err, says));
  };
  expect({}, 2, "robot 1 has no --base");
  expect({"--base", "pty:" + (folder / "k")}, 2, "robot 1 has no --frames");
  expect({"--at", folder / "a", "--base", "com1"}, 2, "tcp:ADDRESS:PORT");
  expect({"--at", folder / "a", "--start", "1,2"}, 2, "X,Y,DEGREES");
  expect({"--at", folder / "a", "--start", "900,0,0"}, 2, "does not fit");
  expect({"--at", folder / "a", "--robots", "2", "--start", "0,0,0"}, 2, "once for each");
  expect({"--at", folder / "a", "--camera", "big"}, 2, "160x120@10");
  expect({"--at", folder / "a", "--fail", "disk:off"}, 2, "the robot's own");
  expect({"--at", "/proc/no"}, 1, "/proc/no");
  expect({"--at", folder / "a", "--frames", "listen:/no/such/socket"}, 1, "/no/such/socket");
  expect({"--at", folder / "a", "--slow", "0.5"}, 2, "--slow");
}
