// SPDX-License-Identifier: Apache-2.0
// The other commands as a user types them: sim, export, info, merge; usage errors; Ctrl-C.
#include <dlfcn.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>

#include "mapper/files/any_map.hpp"
#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::test;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// A second of the built-in room, mapped once for all cases that only need a map.
const std::string& sim_folder() {
  static const TempFolder folder;
  static const ProgramResult result = run_g3dmap({"sim", "--duration", "0.5", "--quiet", "--out", folder.path()});
  REQUIRE(result.exit_code == 0);
  return folder.path();
}

}  // namespace

TEST_CASE("the built-in room is mapped in lockstep without a drop", "[system][sim]") {
  const std::string report = sim_folder() + "/report.json";
  CHECK(report_number(report, "delivered") == 15);
  CHECK(report_number(report, "integrated") == 15);
  CHECK(report_number(report, "occupied") > 1000);
  CHECK(report_number(report, "file_bytes") == std::filesystem::file_size(sim_folder() + "/map.g3d"));
}

TEST_CASE("one seed gives one map, another seed another", "[system][sim]") {
  const TempFolder folder;
  const auto hash_of = [&](const std::string& name, const std::string& seed, const std::string& threads) {
    const ProgramResult result = run_g3dmap({"sim", "--duration", "0.2", "--seed", seed, "--threads", threads,
                                             "--quiet", "--resolution", "0.1", "--out", folder / name});
    REQUIRE(result.exit_code == 0);
    return report_text((folder / name) + "/report.json", "hash");
  };
  const std::string first = hash_of("a", "7", "1");
  CHECK(hash_of("b", "7", "2") == first);
  CHECK(hash_of("c", "8", "1") != first);
}

TEST_CASE("a summary for people, report.json for scripts", "[system][sim]") {
  const TempFolder folder;
  const ProgramResult people = run_g3dmap({"sim", "--duration", "0.1", "--resolution", "0.1", "--out", folder.path()});
  CHECK(people.exit_code == 0);
  CHECK(contains(people.out, "mapped     3 of 3 frames"));
  CHECK(contains(people.err, "3/3 frames"));
  const ProgramResult scripts =
      run_g3dmap({"sim", "--duration", "0.1", "--resolution", "0.1", "--json", "--quiet", "--out", folder.path()});
  CHECK(scripts.out == read_plain(folder / "report.json"));
  CHECK(scripts.err.empty());
}

TEST_CASE("static mode keeps no free space", "[system][sim]") {
  const TempFolder folder;
  const ProgramResult result = run_g3dmap(
      {"sim", "--duration", "0.1", "--resolution", "0.1", "--mode", "static", "--quiet", "--out", folder.path()});
  CHECK(result.exit_code == 0);
  CHECK(report_number(folder / "report.json", "free") == 0);
  CHECK(report_number(folder / "report.json", "occupied") > 0);
}

TEST_CASE("a map whose memory is full goes on and says so", "[system][sim]") {
  const TempFolder folder;
  const ProgramResult result = run_g3dmap({"sim", "--duration", "2", "--fps", "10", "--resolution", "0.01", "--memory",
                                           "16", "--quiet", "--out", folder.path()});
  CHECK(result.exit_code == 0);
  CHECK(contains(read_plain(folder / "report.json"), "memory was full"));
  CHECK(report_is_balanced(folder / "report.json"));
  CHECK(g3d::mapper::read_any_map(folder / "map.g3d").ok());
}

TEST_CASE("Ctrl-C in the middle saves a map that loads", "[system][sim]") {
  for (const int signal : {SIGINT, SIGTERM}) {
    const TempFolder folder;
    Program program(g3dmap_path(), {"sim", "--rate", "1", "--resolution", "0.1", "--quiet", "--out", folder.path()});
    const std::string part = folder / "trajectory.tum.part";  // there from the start of the run on
    for (int i = 0; i < 2000 && !std::filesystem::exists(part); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    program.send(signal);
    const ProgramResult result = program.finish(std::chrono::seconds(20));
    INFO(result.err);
    CHECK(result.exit_code == 0);
    const auto map = g3d::mapper::read_any_map(folder / "map.g3d");
    REQUIRE(map.ok());
    CHECK(map.value().map->counts().occupied > 0);
    CHECK(contains(read_plain(folder / "report.json"), "interrupted: "));
    CHECK(report_is_balanced(folder / "report.json"));
    CHECK(std::filesystem::exists(folder / "trajectory.tum"));
  }
}

TEST_CASE("a map goes through every format and stays the same where the format can hold it", "[system][export]") {
  const TempFolder folder;
  std::vector<std::string> arguments{"export", sim_folder() + "/map.g3d"};
  for (const char* name : {"a.g3d", "a.ot", "a.bt", "a.ply", "a.pcd", "a.yaml", "a.png"}) {
    arguments.insert(arguments.end(), {"--to", folder / name});
  }
  const ProgramResult result = run_g3dmap(arguments);
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const auto info = [&](const std::string& path) { return run_g3dmap({"info", path, "--json"}).out; };
  const auto hash_line = [](const std::string& json) { return json.substr(json.find("\"hash\"")); };
  CHECK(hash_line(info(folder / "a.g3d")) == hash_line(info(sim_folder() + "/map.g3d")));
  CHECK(contains(info(folder / "a.bt"), "\"resolution_m\": 0.05,"));
  CHECK(std::filesystem::file_size(folder / "a.pgm") > 0);
}

TEST_CASE("merging is commutative and takes poses", "[system][merge]") {
  const TempFolder folder;
  const std::string a = sim_folder() + "/map.g3d";
  const std::string b = folder / "b.g3d";
  REQUIRE(run_g3dmap({"merge", a, "--pose", "1,0,0,0,0,0", "--out", b}).exit_code == 0);
  const ProgramResult ab = run_g3dmap({"merge", a, b, "--out", folder / "ab.g3d"});
  const ProgramResult ba = run_g3dmap({"merge", b, a, "--out", folder / "ba.g3d"});
  REQUIRE(ab.exit_code == 0);
  CHECK(ab.out.substr(ab.out.find("hash")) == ba.out.substr(ba.out.find("hash")));
  CHECK(run_g3dmap({"merge", a, b, "--pose", "0,0,0,0,0,0", "--out", folder / "x.g3d"}).exit_code == 2);
  const ProgramResult bad = run_g3dmap({"merge", a, "--pose", "0,0,0,0,0,nan", "--out", folder / "x.g3d"});
  CHECK(bad.exit_code == 2);
  CHECK(contains(bad.err, "x,y,z,roll,pitch,yaw"));
}

TEST_CASE("bad usage is exit code 2 and says what is wrong", "[system][usage]") {
  const std::vector<std::vector<std::string>> cases{
      {},
      {"fly"},
      {"sim"},
      {"sim", "--out", "x", "--bogus"},
      {"sim", "--out", "x", "--resolution", "5"},
      {"sim", "--out", "x", "--threads", "0"},
      {"sim", "--out", "x", "--integrator", "magic"},
      {"replay", "--out", "x"},
      {"export", "a.g3d"},
      {"export", sim_folder() + "/map.g3d", "--to", "a.doc"},
  };
  for (const auto& arguments : cases) {
    const ProgramResult result = run_g3dmap(arguments);
    INFO((arguments.empty() ? "no arguments" : arguments.back()));
    CHECK(result.exit_code == 2);
    CHECK_FALSE(result.err.empty());
  }
}

TEST_CASE("what robots cannot do is bad usage, and says which option and how", "[system][usage][explore]") {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"--robots", "0"}, "--robots"},
      {{"--robots", "17"}, "--robots"},
      {{"--robots", "2", "--rate", "1"}, "--rate"},
      {{"--robots", "1", "--loss", "0.1"}, "--loss"},
      {{"--robots", "1", "--camera", "160"}, "--camera '160'"},
      {{"--robots", "1", "--camera", "160x120"}, "160x120@10"},
      {{"--robots", "1", "--camera", "@10x3"}, "--camera"},
      {{"--robots", "1", "--camera", "8x120@10"}, "16 to"},
      {{"--robots", "1", "--camera", "160x120@0"}, "0.5 to"},
      {{"--robots", "1", "--camera", "160x120@nan"}, "0.5 to"},
      {{"--robots", "1", "--camera", "1e9x120@10"}, "--camera"},
      {{"--robots", "1", "--area", "0,0,1"}, "X0,Y0,X1,Y1"},
      {{"--robots", "1", "--area", "0,0,1,1,"}, "X0,Y0,X1,Y1"},
      {{"--robots", "1", "--area", "2,0,1,1"}, "X0 < X1"},
      {{"--robots", "1", "--area", "a,0,1,1"}, "--area"},
      {{"--robots", "1", "--crop", "0,0,1"}, "--crop '0,0,1': not X0,Y0,X1,Y1"},
      {{"--robots", "1", "--crop", "0,0,5,5"}, "maze: only map_server maps (.yaml) can be cropped"},
      {{"--crop", "5,0,0,5"}, "X0 < X1"},
      {{"--robots", "1", "--drift", "-1"}, "--drift"},
      {{"--robots", "1", "--camera-path", "some.path"}, "--camera-path"},
      {{"--robots", "1", "--laps", "2"}, "--laps"},
      {{"--robots", "1", "--mode", "static"}, "free space"},
      {{"--robots", "1", "--window", "5"}, "--window"},
      {{"--robots", "1", "--mask", "mask.png"}, "--mask"},
      {{"--robots", "1", "--footprint", "board"}, "--footprint"},
      {{"--robots", "1", "--camera", "160x120@10", "--fps", "5"}, "--fps"},
      {{"--area", "0,0,1,1"}, "--robots 1"},
      {{"--robots", "1", "--odometry", "none"}, "--odometry none"},
      {{"--robots", "1", "--motion", "free"}, "--motion free"},
      {{"--robots", "1", "--loops"}, "add --odometry aligned"},
      {{"--robots", "1", "--odometry", "aligned", "--loops", "--mapper", "cuda"}, "does not go with --mapper cuda"},
      {{"--camera", "160x120@10"}, "--robots 1"},
      {{"--at", "1:pause"}, "--robots 1"},
      {{"--fail", "line:off"}, "--robots 1"},
      {{"--battery", "3"}, "--robots 1"},
      {{"--robots", "1", "--at", "pause"}, "20:pause"},
      {{"--robots", "1", "--at", "1:dance"}, "20:pause"},
      {{"--robots", "1", "--fail", "wheel:off"}, "camera:stuck@20+5"},
      {{"--robots", "1", "--battery", "0"}, "--battery"},
  };
  const TempFolder folder;
  for (const auto& [extra, named] : cases) {
    std::vector<std::string> arguments{"sim", "--world", "maze", "--quiet", "--out", folder / "out"};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    const ProgramResult result = run_g3dmap(arguments);
    INFO(extra.back() << ": " << result.err);
    CHECK(result.exit_code == 2);
    CHECK(contains(result.err, named));
    CHECK_FALSE(std::filesystem::exists(folder / "out"));
  }
}

TEST_CASE("what does not go with correcting the whole map is refused, and nothing is made", "[system][usage]") {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"--loops"}, "add --odometry aligned"},
      {{"--odometry", "aligned", "--loops", "--checkpoint", "5"}, "does not go with --checkpoint"},
      {{"--odometry", "aligned", "--loops", "--mapper", "cuda"}, "does not go with --mapper cuda"},
  };
  const TempFolder folder;
  for (const auto& [extra, named] : cases) {
    std::vector<std::string> arguments{"sim", "--quiet", "--out", folder / "out"};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    const ProgramResult result = run_g3dmap(arguments);
    INFO(extra.back() << ": " << result.err);
    CHECK(result.exit_code == 2);
    CHECK(contains(result.err, named));
    CHECK_FALSE(std::filesystem::exists(folder / "out"));
  }
}

TEST_CASE("what cannot be done at run time is exit code 1 and names the file", "[system][usage]") {
  const TempFolder folder;
  write_plain(folder / "bad.g3d", "not a map");
  write_plain(folder / "bad.world", "box 1 2\n");
  write_plain(folder / "bad.toml", "[map]\nresolution_m = 99\n");
  const auto expect = [&](const std::vector<std::string>& arguments, const std::string& named) {
    const ProgramResult result = run_g3dmap(arguments);
    INFO(result.err);
    CHECK(result.exit_code == 1);
    CHECK(contains(result.err, named));
  };
  expect({"info", folder / "bad.g3d"}, "bad.g3d");
  expect({"info", folder / "none.bt"}, "none.bt");
  expect({"export", folder / "bad.g3d", "--to", folder / "x.ply"}, "bad.g3d");
  expect({"sim", "--world", folder / "bad.world", "--camera-path", folder / "none", "--out", folder / "o"},
         "bad.world:1");
  expect({"sim", "--board", folder / "bad.toml", "--out", folder / "o"}, "bad.toml:2");
  if (dlopen("libcuda.so.1", RTLD_NOW) == nullptr) {
    expect({"sim", "--mapper", "cuda", "--out", folder / "o"}, "use --mapper cpu or auto");
  }
  expect({"sim", "--mask", folder / "none.png", "--out", folder / "o"}, "none.png");
}

TEST_CASE("help and version are there at once", "[system][usage]") {
  for (const char* command : {"replay", "sim", "export", "info", "merge", "mask"}) {
    const ProgramResult help = run_g3dmap({command, "--help"});
    CHECK(help.exit_code == 0);
    CHECK(contains(help.out, "Example"));
  }
  auto fastest = std::chrono::steady_clock::duration::max();
  for (int i = 0; i < 5; ++i) {
    const auto start = std::chrono::steady_clock::now();
    CHECK(run_g3dmap({"--version"}).out.starts_with("g3dmap "));
    fastest = std::min(fastest, std::chrono::steady_clock::now() - start);
  }
  CHECK(fastest < std::chrono::milliseconds(50));
}
