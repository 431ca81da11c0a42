// SPDX-License-Identifier: Apache-2.0
// A fleet of real processes on this machine: robots in simulated buildings and a base station, joined by UDP over the
// loopback interface and by one key; `g3dmap peers`; and what the command line refuses.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "hal/linux/control_socket.hpp"
#include "mapper/files/any_map.hpp"
#include "mapper/map_hash.hpp"
#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::test;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Programs whose ports nobody else uses, as far as the process number tells them apart.
struct FleetProcesses {
  FleetProcesses() : first_port(20'000 + static_cast<int>(::getpid() % 8000) * 4) {
    REQUIRE(run_g3dmap({"key", "--out", folder / "fleet.key"}).exit_code == 0);
    REQUIRE(run_g3dmap({"key", "--out", folder / "other.key"}).exit_code == 0);
    const std::string network = "[network]\ngroup = \"none\"\nbandwidth_kBps = 4000\n";
    write_plain(folder / "robot.toml",
                "name = \"robot\"\n[map]\nresolution_m = 0.1\nthreads = 1\nmemory_mb = 64\n" + network);
    write_plain(folder / "station.toml",
                "name = \"station\"\n[base]\nline = \"none\"\n[camera]\nsource = \"none\"\n[map]\nresolution_m = "
                "0.1\nmemory_mb = 64\n" +
                    network);
  }
  /// Numbers 0 to 3. All others are its peers.
  [[nodiscard]] std::vector<std::string> arguments(const std::string& board, int number, const std::string& key) const {
    std::vector<std::string> all{"run",
                                 "--board",
                                 folder / (board + ".toml"),
                                 "--key",
                                 folder / key,
                                 "--robot",
                                 "a" + std::to_string(number),
                                 "--port",
                                 port(number),
                                 "--quiet",
                                 "--out",
                                 out(number)};
    for (int other = 0; other < 4; ++other) {
      if (other == number) continue;
      all.insert(all.end(), {"--peer", "127.0.0.1:" + port(other)});
    }
    return all;
  }
  [[nodiscard]] std::vector<std::string> robot(int number, const std::string& duration_s,
                                               const std::string& key = "fleet.key") const {
    std::vector<std::string> all = arguments("robot", number, key);
    all.insert(all.end(), {"--world", "two_rooms", "--camera", "80x60@5", "--start", std::to_string(number),
                           "--duration", duration_s, "--settle", "30"});
    return all;
  }
  [[nodiscard]] std::vector<std::string> station() const { return arguments("station", 0, "fleet.key"); }
  [[nodiscard]] std::string out(int number) const { return folder / ("out" + std::to_string(number)); }
  [[nodiscard]] std::string report(int number) const { return out(number) + "/report.json"; }
  [[nodiscard]] std::string port(int number) const { return std::to_string(first_port + number); }
  [[nodiscard]] bool says(int number, const std::string& part, const std::string& request = "peers") const {
    for (int i = 0; i < 1000; ++i) {
      const auto status = hal::ask_control_socket(out(number) + "/control", request);
      if (status.ok() && contains(status.value(), part)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }
  [[nodiscard]] bool has_turned(int number, double turned_rad) const {
    const std::string name = "\"turned_rad\": ";
    for (int i = 0; i < 3000; ++i) {
      const auto status = hal::ask_control_socket(out(number) + "/control", "status");
      const std::size_t at = status.ok() ? status.value().find(name) : std::string::npos;
      if (at != std::string::npos && std::stod(status.value().substr(at + name.size())) >= turned_rad) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }
  TempFolder folder;
  int first_port;
};

std::string id_of(int number) { return "\"id\": \"00000000000000a" + std::to_string(number) + "\""; }

}  // namespace

TEST_CASE("robots and a base station in processes of their own end with one map, and a stranger is shut out",
          "[system][fleet][waits]") {
  const FleetProcesses fleet;
  Program station(g3dmap_path(), fleet.station());
  Program one(g3dmap_path(), fleet.robot(1, "100"));
  Program two(g3dmap_path(), fleet.robot(2, "100"));
  Program stranger(g3dmap_path(), fleet.robot(3, "100", "other.key"));
  CHECK(fleet.says(0, id_of(1)));
  CHECK(fleet.says(0, id_of(2)));
  CHECK(fleet.says(1, id_of(2)));
  CHECK(fleet.says(3, "\"datagrams\""));
  std::this_thread::sleep_for(std::chrono::seconds(2));
  const ProgramResult peers = run_g3dmap({"peers", "--at", fleet.out(0)});
  CHECK(peers.exit_code == 0);
  CHECK(contains(peers.out, "robot 00000000000000a0, key of epoch 1"));
  CHECK(contains(peers.out, "robot 00000000000000a1  alive  127.0.0.1:" + fleet.port(1)));
  CHECK(contains(peers.out, "forged"));

  // At the same time, so that each goes on until both have told the other all.
  for (const Program* robot : {&one, &two, &stranger}) robot->send(SIGINT);
  for (Program* robot : {&one, &two, &stranger}) {
    const ProgramResult result = robot->finish(std::chrono::seconds(60));
    INFO(result.err);
    CHECK(result.exit_code == 0);
  }
  const auto stopped = hal::ask_control_socket(fleet.out(0) + "/control", "stop");
  REQUIRE(stopped);
  CHECK(contains(stopped.value(), "stopped"));
  const ProgramResult result = station.finish(std::chrono::seconds(60));
  INFO(result.err);
  CHECK(result.exit_code == 0);

  const std::string hash = report_text(fleet.report(0), "merged_hash");
  CHECK(report_text(fleet.report(1), "merged_hash") == hash);
  CHECK(report_text(fleet.report(2), "merged_hash") == hash);
  CHECK(report_text(fleet.report(3), "merged_hash") != hash);
  // What the station has written is that map, and both robots' is more than either's.
  const auto map = mapper::read_any_map(fleet.out(0) + "/map.g3d");
  REQUIRE(map);
  CHECK(mapper::map_hash(*map.value().map) == hash);
  CHECK(report_number(fleet.report(0), "free") > 0);
  CHECK(report_text(fleet.report(1), "hash") != hash);
  for (const char* file : {"/map.ply", "/map.png", "/ground.pgm", "/ground.yaml"}) {
    CHECK(std::filesystem::exists(fleet.out(0) + file));
  }
  CHECK(std::filesystem::exists(fleet.out(1) + "/merged/map.g3d"));
  for (const int number : {0, 1, 2}) {
    const std::string text = read_plain(fleet.report(number));
    CHECK(contains(text, "\"robots\": ["));
    CHECK_FALSE(contains(text, "00000000000000a3"));
    CHECK(contains(text, "\"forged\": "));
  }
  CHECK_FALSE(contains(read_plain(fleet.report(3)), "00000000000000a0"));
}

TEST_CASE("robots that correct their maps share submaps, and all end with one map", "[system][fleet][waits]") {
  const FleetProcesses fleet;
  Program station(g3dmap_path(), fleet.station());
  const auto looped = [&](int number) {
    std::vector<std::string> all = fleet.robot(number, "100");
    all.insert(all.end(), {"--drift", "1", "--odometry", "aligned", "--loops"});
    return all;
  };
  Program one(g3dmap_path(), looped(1));
  Program two(g3dmap_path(), looped(2));
  CHECK(fleet.says(0, id_of(1)));
  CHECK(fleet.says(0, id_of(2)));
  // Each looks round first, and that makes a submap; the rest becomes another one at the end.
  for (const int number : {1, 2}) REQUIRE(fleet.has_turned(number, 7.0));
  one.send(SIGINT);
  two.send(SIGINT);
  for (Program* robot : {&one, &two}) {
    const ProgramResult result = robot->finish(std::chrono::seconds(60));
    INFO(result.err);
    CHECK(result.exit_code == 0);
  }
  station.send(SIGINT);
  CHECK(station.finish(std::chrono::seconds(60)).exit_code == 0);
  const std::string hash = report_text(fleet.report(0), "merged_hash");
  for (const int number : {1, 2}) {
    CHECK(report_text(fleet.report(number), "merged_hash") == hash);
    CHECK(report_number(fleet.report(number), "published") >= 2);
    CHECK(report_number(fleet.report(number), "published_poses") >= 2);
  }
  // More than either has seen.
  const auto merged = mapper::read_any_map(fleet.out(0) + "/map.g3d");
  REQUIRE(merged);
  for (const int number : {1, 2}) {
    const auto own = mapper::read_any_map(fleet.out(number) + "/map.g3d");
    REQUIRE(own);
    CHECK(merged.value().map->counts().known() > own.value().map->counts().known());
  }
}

TEST_CASE("a robot that is killed leaves its map with the base station, which saves it meanwhile",
          "[system][fleet][waits]") {
  const FleetProcesses fleet;
  std::vector<std::string> arguments = fleet.station();
  arguments.insert(arguments.end(), {"--checkpoint", "0.5"});
  Program station(g3dmap_path(), arguments);
  Program robot(g3dmap_path(), fleet.robot(1, "60"));
  REQUIRE(fleet.says(0, "\"holds_the_same\": true"));
  std::this_thread::sleep_for(std::chrono::seconds(1));
  robot.send(SIGKILL);
  CHECK(robot.finish().signal == SIGKILL);
  // What is in the map file now nobody but the station has any more.
  for (int i = 0; i < 500 && !std::filesystem::exists(fleet.out(0) + "/map.g3d"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const auto saved = mapper::read_any_map(fleet.out(0) + "/map.g3d");
  REQUIRE(saved);
  CHECK(saved.value().map->counts().free > 0);
  station.send(SIGINT);
  const ProgramResult result = station.finish(std::chrono::seconds(60));
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK(report_number(fleet.report(0), "free") > 0);
  CHECK(contains(read_plain(fleet.report(0)), id_of(1)));
  CHECK(contains(read_plain(fleet.report(0)), "times meanwhile"));
}

TEST_CASE("a robot that is alone says so, and a key that is no key is told", "[system][fleet][waits]") {
  const FleetProcesses fleet;
  std::vector<std::string> alone{
      "run",   "--board",   fleet.folder / "robot.toml", "--world", "two_rooms", "--camera", "80x60@5", "--quiet",
      "--out", fleet.out(1)};
  Program program(g3dmap_path(), alone);
  REQUIRE(fleet.says(1, "\"state\"", "status"));
  const ProgramResult peers = run_g3dmap({"peers", "--at", fleet.out(1)});
  CHECK(peers.exit_code == 1);
  CHECK(contains(peers.err, "this robot is alone"));
  program.send(SIGINT);
  CHECK(program.finish(std::chrono::seconds(60)).exit_code == 0);
  CHECK_FALSE(contains(read_plain(fleet.report(1)), "merged_hash"));
  CHECK(run_g3dmap({"peers", "--at", fleet.out(2)}).exit_code == 1);

  alone.insert(alone.end(), {"--key", fleet.folder / "none.key"});
  CHECK(run_g3dmap(alone).exit_code == 1);
  write_plain(fleet.folder / "bad.key", "no key\n");
  alone.back() = fleet.folder / "bad.key";
  const ProgramResult bad = run_g3dmap(alone);
  CHECK(bad.exit_code == 1);
  CHECK(contains(bad.err, "bad.key"));
}

TEST_CASE("bad usage of a fleet is exit code 2", "[system][fleet][usage]") {
  const FleetProcesses fleet;
  const std::string key = fleet.folder / "fleet.key";
  const std::vector<std::vector<std::string>> robots{
      {"--robot", "a1"},
      {"--peer", "127.0.0.1:7177"},
      {"--port", "7177"},
      {"--settle", "5"},
      {"--checkpoint", "5"},
      {"--start", "0"},
      {"--start", "17"},
      {"--start", "1.5"},
      {"--start", "0,0"},
      {"--start", "1000,1000,0"},
      {"--start", "here"},
      {"--key", key, "--robot", "0"},
      {"--key", key, "--robot", "xyz"},
      {"--key", key, "--port", "0"},
      {"--key", key, "--port", "65536"},
      {"--key", key, "--peer", "robot2"},
      {"--key", key, "--peer", "127.0.0.1"},
      {"--key", key, "--peer", "127.0.0.1:0"},
      {"--key", key, "--peer", "300.0.0.1:7177"},
      {"--key", key, "--settle", "-1"},
      {"--key", key, "--keep", fleet.folder / "kept", "--odometry", "aligned", "--loops"},
  };
  const std::vector<std::vector<std::string>> stations{
      {},
      {"--key", "none"},
      {"--key", key, "--camera", "80x60@5"},
      {"--key", key, "--area", "0,0,1,1"},
      {"--key", key, "--start", "1"},
      {"--key", key, "--drift", "1"},
      {"--key", key, "--record", "log"},
      {"--key", key, "--odometry", "aligned"},
      {"--key", key, "--at", "1:pause"},
      {"--key", key, "--battery", "5"},
      {"--key", key, "--fail", "line:off@1+1"},
      {"--key", key, "--checkpoint", "5"},
  };
  const auto refuses = [&](const std::string& board, const std::vector<std::string>& said) {
    std::vector<std::string> all{"run", "--board", fleet.folder / (board + ".toml"), "--duration", "0.1", "--quiet"};
    if (board == "robot") all.insert(all.end(), {"--world", "two_rooms"});
    all.insert(all.end(), said.begin(), said.end());
    const ProgramResult result = run_g3dmap(all);
    INFO(board << ": " << (said.empty() ? "nothing" : said[said.size() > 2 ? 2 : 0]) << ": " << result.err);
    CHECK(result.exit_code == 2);
    CHECK_FALSE(result.err.empty());
  };
  for (const auto& said : robots) refuses("robot", said);
  for (const auto& said : stations) refuses("station", said);
  CHECK(run_g3dmap({"peers", "out"}).exit_code == 2);
}
