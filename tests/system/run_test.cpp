// SPDX-License-Identifier: Apache-2.0
// `g3dmap run` as a user starts it: in its own simulated building, at the line of a base that somebody else simulates,
// and with everything wrong that a board file can say.
#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

#include "hal/replay/recorded_odometry.hpp"
#include "hal/sim/real_time_building.hpp"
#include "mapper/files/any_map.hpp"
#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::test;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Other programs may keep the machine busy.
bool becomes_true(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!condition()) {
    if (std::chrono::steady_clock::now() >= end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

/// What a recording that is still being written says of the way so far.
hal::RecordedOdometry odometry_of(const std::string& path) {
  if (!std::filesystem::exists(path) || std::filesystem::file_size(path) == 0) return {};
  const auto log = hal::KobukiLog::open(path);
  return log ? hal::recompute_odometry(log.value(), hal::Pose{}) : hal::RecordedOdometry{};
}

std::vector<std::string> in_simulation(const TempFolder& folder, const std::vector<std::string>& more) {
  write_plain(folder / "small.toml", "name = \"small\"\n[map]\nresolution_m = 0.1\nthreads = 1\nmemory_mb = 64\n");
  std::vector<std::string> arguments{"run",     "--board", folder / "small.toml", "--world", "two_rooms", "--camera",
                                     "80x60@5", "--quiet"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

}  // namespace

TEST_CASE("a robot explores in real time until Ctrl-C; then it stands, and everything is saved",
          "[system][run][waits]") {
  const TempFolder folder;
  const std::string out = folder / "out", log = folder / "log";
  Program program(g3dmap_path(), in_simulation(folder, {"--record", log, "--out", out}));
  CHECK(becomes_true([&] { return odometry_of(log + "/kobuki.bin").rotation_rad > 1.0; }));
  program.send(SIGINT);
  const ProgramResult result = program.finish(std::chrono::seconds(60));
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(result.out.empty());

  const std::string report = out + "/report.json";
  const std::string text = read_plain(report);
  CHECK(report_is_balanced(report));
  CHECK(report_number(report, "integrated") > 0);
  CHECK(report_number(report, "rejected_packets") == 0);
  CHECK(report_number(report, "skipped_bytes") == 0);
  CHECK(contains(text, "\"stands\": true"));  // the simulated base itself was told zero
  CHECK(contains(text, "\"guard_alive\": true"));
  CHECK(contains(text, "\"board\": \"small\""));
  CHECK(contains(text, "\"control_jitter\""));
  CHECK(contains(text, "interrupted: "));
  const auto map = mapper::read_any_map(out + "/map.g3d");
  REQUIRE(map.ok());
  CHECK(map.value().map->counts().free > 0);
  const auto way = hal::read_trajectory(out + "/trajectory.tum");
  REQUIRE(way.ok());
  CHECK(way.value().size() == report_number(report, "integrated"));
  // Everything that came over the line is in the recording.
  CHECK(odometry_of(log + "/kobuki.bin").rejects.accepted_frames == report_number(report, "packets"));
}

TEST_CASE("a robot stops when its time is over, and writes nothing where it was not asked to", "[system][run][waits]") {
  const TempFolder folder;
  const ProgramResult result = run_g3dmap(in_simulation(folder, {"--duration", "1", "--json"}));
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK(contains(result.out, "\"stands\": true"));
  CHECK_FALSE(contains(result.out, "interrupted: "));
  CHECK(folder.listing() == "small.toml\n");
}

TEST_CASE("a base at a real line stands without a camera, and its bytes are recorded", "[system][run][waits]") {
  const TempFolder folder;
  const std::string out = folder / "out", log = folder / "log";
  hal::RealClock clock;
  hal::World world;
  world.add_floor({0.0, 0.0, 0.0}, 20.0, 20.0, 0.1, {});
  hal::SimBuildingOptions options;
  options.camera = hal::scaled_kinect(64, 48);
  options.robots.resize(1);
  auto building = hal::RealTimeBuilding::start(std::move(world), options, clock, {folder / "kobuki"});
  REQUIRE(building.ok());
  write_plain(folder / "b.toml", "[base]\nline = \"" + (folder / "kobuki") +
                                     "\"\n[camera]\nsource = \"none\"\n[map]\nresolution_m = 0.1\nmemory_mb = 16\n");
  Program program(g3dmap_path(), {"run", "--board", folder / "b.toml", "--record", log, "--quiet", "--out", out});
  CHECK(becomes_true([&] { return odometry_of(log + "/kobuki.bin").poses.size() > 50; }));
  program.send(SIGTERM);
  const ProgramResult result = program.finish(std::chrono::seconds(60));
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const std::string report = read_plain(out + "/report.json");
  CHECK(contains(report, "\"line\": \"" + (folder / "kobuki") + "\""));
  CHECK(contains(report, "\"stands\": true"));
  CHECK(report_number(out + "/report.json", "packets") > 50);
  CHECK(report_number(out + "/report.json", "delivered") == 0);
  CHECK_FALSE(contains(report, "\"collisions\""));  // nobody knows from outside
  building.value()->with(0, [](hal::SimBuilding& b, hal::BaseCable&) {
    CHECK(b.kobuki(0).drive() == hal::kobuki::BaseControl{});
    CHECK(b.record(0).driven_m == 0.0);
  });
}

TEST_CASE("what is wrong with a board or an option is said before anything moves", "[system][run]") {
  const TempFolder folder;
  const std::string board = folder / "b.toml";
  const auto expect = [&](const std::string& text, const std::vector<std::string>& more, int exit_code,
                          const std::string& says) {
    write_plain(board, text);
    std::vector<std::string> arguments{"run", "--board", board, "--quiet", "--duration", "1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramResult result = run_g3dmap(arguments);
    INFO(result.err);
    CHECK(result.exit_code == exit_code);
    CHECK(contains(result.err, says));
  };
  CHECK(run_g3dmap({"run"}).exit_code == 2);
  CHECK(contains(run_g3dmap({"run", "--board", folder / "none.toml"}).err, "none.toml"));
  expect("[base]\nline = \"ttyUSB0\"\n", {}, 1, "base.line must be sim, auto, none, or the whole path");
  expect("[base]\nline = \"/dev/none\"\n", {}, 2, "do not go together");
  expect("[camera]\nsource = \"none\"\n", {}, 2, "do not go together");
  expect("[base]\nline = \"/dev/none\"\n[camera]\nsource = \"none\"\n", {}, 1, "/dev/none: no such port");
  expect("[base]\nline = \"/dev/null\"\n[camera]\nsource = \"none\"\n", {}, 1, "/dev/null: is no serial port");
  expect("[base]\nline = \"auto\"\n[camera]\nsource = \"none\"\n", {}, 1, "plug the base in");
  expect("[base]\nline = \"auto\"\n[camera]\nsource = \"none\"\n", {"--camera", "64x48@5"}, 2, "--camera");
  expect("[map]\nmode = \"static\"\n", {}, 2, "static");
  expect("", {"--record"}, 2, "--record");
  expect("", {"--record", folder / "one", "--out", folder / "one"}, 2, "need a folder each");
  expect("", {"--slow", "2"}, 2, "g3dmap building");
  expect("", {"--loops"}, 2, "add --odometry aligned");
  expect("", {"--loops", "--odometry", "aligned", "--mapper", "cuda"}, 2, "does not go with --mapper cuda");
  expect("", {"--camera", "big"}, 2, "160x120@10");
  expect("", {"--area", "1,1,0,0"}, 2, "--area");
  expect("", {"--world", folder / "none.world"}, 1, "none.world");
  expect("", {"--world", "two_rooms", "--out", "/proc/g3dmap_out"}, 1, "/proc/g3dmap_out");
}

TEST_CASE("a robot in real time looks for places that it sees again, and says so", "[system][run][waits]") {
  const TempFolder folder;
  const std::string out = folder / "out";
  const ProgramResult result = run_g3dmap(
      in_simulation(folder, {"--odometry", "aligned", "--loops", "--drift", "1", "--duration", "12", "--out", out}));
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(report_number(out + "/report.json", "submaps") >= 1);
  CHECK(report_number(out + "/report.json", "refused_blocks") == 0);
  CHECK(report_is_balanced(out + "/report.json"));
}
