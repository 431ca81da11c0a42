// SPDX-License-Identifier: Apache-2.0
// `g3dmap sim --robots 1` as a user runs it: a small world is explored to the end, and a run repeats exactly.
#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "hal/sim/builtin_worlds.hpp"
#include "mapper/files/any_map.hpp"
#include "mapper/map_hash.hpp"
#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::test;

namespace {

/// Two rooms with a doorway of 0.7 m between them, a cupboard in one and a table in the other.
constexpr const char* kTwoRooms =
    "room 0 0 0  7 4 2.5 0.1\n"
    "box 0 -1.3 0  0.1 1.4 2.5\n"
    "box 0 1.05 0  0.1 1.9 2.5\n"
    "box -2.8 1.6 0  0.8 0.6 1.8\n"
    "box 2 -0.4 0  0.8 0.8 0.7\n"
    "start -2 -0.5 60\n";

/// Two rooms with a sill of 3 cm in one of two doorways, a cable duct of 3 cm across a part of one, and in its far part
/// the floor lies 4 cm lower: the wheels would hang over that edge.
constexpr const char* kSills =
    "floor -0.5 0 0  7 5 0.2\n"
    "floor 4 0 -0.04  2 5 0.2\n"
    "box 0.5 0 2.4  9.2 5.2 0.1\n"
    "box -4.05 0 -0.2  0.1 5.2 2.6\n"
    "box 5.05 0 -0.2  0.1 5.2 2.6\n"
    "box 0.5 2.55 -0.2  9.2 0.1 2.6\n"
    "box 0.5 -2.55 -0.2  9.2 0.1 2.6\n"
    "box -1.2 1.1 0  0.1 0.7 2.4\n"
    "box -1.2 -1.35 0  0.1 2.3 2.4\n"
    "box -1.2 0.25 0  0.1 0.9 0.03\n"
    "box 1.4 -1.2 0  0.12 2.6 0.03\n"
    "start -2.6 0.2 0\n";

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::vector<std::string> explore(const std::string& world, const std::string& out,
                                 const std::vector<std::string>& extra = {}) {
  std::vector<std::string> arguments{"sim",      "--world",    world,     "--robots", "1",
                                     "--camera", "160x120@10", "--quiet", "--out",    out};
  arguments.insert(arguments.end(), extra.begin(), extra.end());
  return arguments;
}

/// The report without what may differ between two runs: how long stages took, and how the run was started.
std::string without_times(const std::string& path) {
  std::string text = read_plain(path);
  for (const char* name : {"\"stages_us\": {", "\"run\": {"}) {
    const std::size_t from = text.find(name);
    REQUIRE(from != std::string::npos);
    int depth = 0;
    std::size_t to = text.find('{', from);
    do {
      depth += text[to] == '{' ? 1 : text[to] == '}' ? -1 : 0;
      ++to;
    } while (depth > 0);
    text.erase(from, to - from);
  }
  return text;
}

}  // namespace

TEST_CASE("two rooms are explored to the end, and the robot comes home", "[system][explore]") {
  const TempFolder folder;
  write_plain(folder / "rooms.world", kTwoRooms);
  const std::string out = folder / "out";
  const ProgramResult result = run_g3dmap(explore(folder / "rooms.world", out));
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const std::string report = out + "/report.json";
  CHECK(contains(read_plain(report), "\"home\": true"));
  CHECK_FALSE(contains(read_plain(report), "\"t99_s\": null"));
  CHECK(report_number(report, "t99_s") < 180);
  CHECK(report_number(report, "collisions") == 0);
  CHECK(report_number(report, "open") == 0);
  CHECK(report_number(report, "path_m") > 3);
  CHECK(report_number(report, "delivered") == report_number(report, "integrated"));
  CHECK(report_is_balanced(report));
  for (const char* name : {"map.g3d", "map.ply", "ground.pgm", "trajectory.tum", "map.png", "exploration.png"}) {
    CHECK(std::filesystem::file_size(out + "/" + name) > 0);
  }
  const auto map = g3d::mapper::read_any_map(out + "/map.g3d");
  REQUIRE(map.ok());
  CHECK(map.value().map->counts().occupied == report_number(report, "occupied"));
}

TEST_CASE("one world and seed give one map, way and report, on one core and on two", "[system][explore]") {
  const TempFolder folder;
  write_plain(folder / "rooms.world", kTwoRooms);
  const auto run = [&](const std::string& name, const std::string& seed, const std::string& threads) {
    const ProgramResult result = run_g3dmap(
        explore(folder / "rooms.world", folder / name, {"--seed", seed, "--threads", threads, "--duration", "40"}));
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    return folder / name;
  };
  const std::string one = run("one", "3", "1");
  const std::string two = run("two", "3", "2");
  const std::string other = run("other", "4", "1");
  CHECK(report_text(one + "/report.json", "hash") == report_text(two + "/report.json", "hash"));
  CHECK(read_plain(one + "/trajectory.tum") == read_plain(two + "/trajectory.tum"));
  CHECK(without_times(one + "/report.json") == without_times(two + "/report.json"));
  CHECK(read_plain(one + "/exploration.png") == read_plain(two + "/exploration.png"));
  CHECK(report_text(one + "/report.json", "hash") != report_text(other + "/report.json", "hash"));
  CHECK(read_plain(one + "/trajectory.tum") != read_plain(other + "/trajectory.tum"));
}

TEST_CASE("sills, cable ducts and lower floor that voxels are too coarse for are seen, and left alone",
          "[system][explore]") {
  const TempFolder folder;
  write_plain(folder / "sills.world", kSills);
  const std::string out = folder / "out";
  const ProgramResult result = run_g3dmap(explore(folder / "sills.world", out));
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const std::string report = read_plain(out + "/report.json");
  CHECK(contains(report, "\"home\": true"));
  CHECK_FALSE(contains(report, "\"t95_s\": null"));
  // From the side that it has not looked at it may creep up to a duct: nearer than 0.8 m nothing is measured.
  CHECK(report_number(out + "/report.json", "fastest_collision_mps") <= 0.1);
  CHECK(report_number(out + "/report.json", "wheel_drop") == 0);
  CHECK(report_number(out + "/report.json", "path_m") > 5);
}

TEST_CASE("an area limit keeps the robot on its side", "[system][explore]") {
  const TempFolder folder;
  write_plain(folder / "rooms.world", kTwoRooms);
  const std::string out = folder / "out";
  REQUIRE(run_g3dmap(explore(folder / "rooms.world", out, {"--area", "-3.5,-2,-0.3,2"})).exit_code == 0);
  CHECK(contains(read_plain(out + "/report.json"), "\"home\": true"));
  CHECK(report_number(out + "/report.json", "outside_area") > 0);
  const std::string way = read_plain(out + "/trajectory.tum");
  std::size_t poses = 0;
  for (std::size_t at = 0; at < way.size(); at = way.find('\n', at) + 1) {
    if (way[at] == '#') continue;
    CHECK(std::stod(way.substr(way.find(' ', at))) < 0.0);  // x of the camera
    ++poses;
  }
  CHECK(poses > 50);
}

TEST_CASE("a robot that is told to stop by Ctrl-C leaves a map and a report", "[system][explore]") {
  const TempFolder folder;
  Program program(g3dmap_path(), explore("house", folder / "out", {"--rate", "1"}));
  for (int i = 0; i < 2000 && !std::filesystem::exists(folder / "out/trajectory.tum.part"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  program.send(SIGINT);
  const ProgramResult result = program.finish(std::chrono::seconds(30));
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK(g3d::mapper::read_any_map(folder / "out/map.g3d").ok());
  CHECK(contains(read_plain(folder / "out/report.json"), "interrupted: "));
  CHECK(contains(read_plain(folder / "out/report.json"), "\"home\": false"));
  CHECK(report_is_balanced(folder / "out/report.json"));
}

TEST_CASE("the benchmark knows all worlds that are there to be explored", "[system][explore]") {
  const std::string script = std::filesystem::path(__FILE__).parent_path() / "../../scripts/bench_explore";
  const std::string text = read_plain(script);
  const std::size_t from = text.find("\nours=\"");
  REQUIRE(from != std::string::npos);
  std::string listed = text.substr(from + 7, text.find('"', from + 7) - from - 7);
  std::string there;
  for (const std::string_view name : g3d::hal::exploration_names())
    there += (there.empty() ? "" : " ") + std::string(name);
  CHECK(listed == there);
}
