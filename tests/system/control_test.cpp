// SPDX-License-Identifier: Apache-2.0
// A person's word while a robot runs: `g3dmap tell`, in real time and in a simulation at a rate, and the same words
// from a script in lockstep.
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "hal/linux/control_socket.hpp"
#include "hal/replay/trajectory_file.hpp"
#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::test;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

ProgramResult tell(const std::string& path, const std::string& word) { return run_g3dmap({"tell", path, word}); }

bool says(const std::string& path, const std::string& part) {
  for (int i = 0; i < 1500; ++i) {
    const auto status = hal::ask_control_socket(path + "/control", "status");
    if (status.ok() && contains(status.value(), part)) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

std::vector<std::string> live(const TempFolder& folder, const std::string& out) {
  write_plain(folder / "small.toml", "name = \"small\"\n[map]\nresolution_m = 0.1\nthreads = 1\nmemory_mb = 64\n");
  return {"run",   "--board", folder / "small.toml", "--world", "two_rooms", "--camera", "80x60@5", "--quiet",
          "--out", out};
}

/// Metres between the poses of two times.
double way_between(const std::string& path, double from_s, double to_s) {
  const auto way = hal::read_trajectory(path);
  REQUIRE(way.ok());
  double sum_m = 0.0;
  for (std::size_t i = 1; i < way.value().size(); ++i) {
    const double at_s = static_cast<double>(way.value()[i].stamp_ns) * 1e-9;
    if (at_s < from_s || at_s > to_s) continue;
    const auto& a = way.value()[i - 1].T_world_camera.translation_m;
    const auto& b = way.value()[i].T_world_camera.translation_m;
    sum_m += std::hypot(b[0] - a[0], b[1] - a[1]);
  }
  return sum_m;
}

}  // namespace

TEST_CASE("a robot in real time is paused, asked, resumed and sent home", "[system][control][waits]") {
  const TempFolder folder;
  const std::string out = folder / "out";
  Program program(g3dmap_path(), live(folder, out));
  REQUIRE(says(out, "\"state\": \"starting\""));
  struct stat info {};
  REQUIRE(::stat((out + "/control").c_str(), &info) == 0);
  CHECK((info.st_mode & 0777) == 0600);

  const ProgramResult paused = tell(out, "pause");
  CHECK(paused.exit_code == 0);
  CHECK(contains(paused.out, "\"state\": \"paused\""));
  std::this_thread::sleep_for(std::chrono::milliseconds(800));  // for braking
  const std::string before = tell(out, "status").out;
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  const std::string after = tell(out + "/control", "status").out;
  const auto pose_of = [](const std::string& json) { return json.substr(json.find("\"pose\""), 100); };
  CHECK(pose_of(before) == pose_of(after));
  CHECK(contains(tell(out, "resume").out, "\"state\": \"starting\""));
  CHECK(contains(tell(out, "stop").out, "\"state\": \"stopped\""));
  CHECK(contains(tell(out, "pause").out, "\"state\": \"stopped\""));  // a stop outranks it
  CHECK(contains(tell(out, "home").out, "\"purpose\": \"returning\""));
  CHECK(contains(tell(out, "resume").out, "\"state\": \"returning\""));
  const ProgramResult result = program.finish(std::chrono::seconds(60));
  INFO(result.err);
  CHECK(result.exit_code == 0);  // home, so it is over
  CHECK(contains(read_plain(out + "/report.json"), "\"state\": \"home\""));
  CHECK(report_number(out + "/report.json", "pause") == 2);
  CHECK_FALSE(std::filesystem::exists(out + "/control"));

  const ProgramResult late = tell(out, "status");
  CHECK(late.exit_code == 1);
  CHECK(contains(late.err, "is a robot running there?"));
}

TEST_CASE("strangers' bytes are refused and counted, and the robot drives on", "[system][control][waits]") {
  const TempFolder folder;
  const std::string out = folder / "out";
  Program program(g3dmap_path(), live(folder, out));
  REQUIRE(says(out, "\"state\": \"starting\""));
  for (const std::string& bytes :
       {std::string("dance"), std::string("pause\0", 6), std::string("{}"), std::string("PAUSE")}) {
    CHECK(contains(hal::ask_control_socket(out + "/control", bytes).value(), "\"error\""));
  }
  CHECK(contains(hal::ask_control_socket(out + "/control", std::string(30'000, 'x')).value(), "too long"));
  CHECK(says(out, "\"state\": \"starting\""));
  CHECK(tell(out, "dance").exit_code == 2);
  program.send(SIGINT);
  CHECK(program.finish(std::chrono::seconds(60)).exit_code == 0);
  CHECK(report_number(out + "/report.json", "unknown_word") == 4);
  CHECK(report_number(out + "/report.json", "too_long") == 1);
}

TEST_CASE("two robots do not share a folder, and one that was killed leaves no lock", "[system][control][waits]") {
  const TempFolder folder;
  const std::string out = folder / "out";
  {
    Program first(g3dmap_path(), live(folder, out));
    REQUIRE(says(out, "\"state\": \"starting\""));
    const ProgramResult second = run_g3dmap(live(folder, out));
    CHECK(second.exit_code == 1);
    CHECK(contains(second.err, "another robot runs here"));
    CHECK(says(out, "\"state\": \"starting\""));
    std::vector<std::string> apart = live(folder, folder / "other");
    apart.insert(apart.end(), {"--control", folder / "mine", "--duration", "1"});
    CHECK(run_g3dmap(apart).exit_code == 0);
    first.send(SIGKILL);
    CHECK(first.finish().signal == SIGKILL);
  }
  CHECK(std::filesystem::exists(out + "/control"));
  std::vector<std::string> again = live(folder, out);
  again.insert(again.end(), {"--duration", "1"});
  CHECK(run_g3dmap(again).exit_code == 0);
}

TEST_CASE("a simulation at a rate is spoken to as well", "[system][control][waits]") {
  const TempFolder folder;
  const std::string out = folder / "out";
  Program program(g3dmap_path(), {"sim", "--world", "two_rooms", "--robots", "1", "--rate", "2", "--camera", "80x60@5",
                                  "--quiet", "--out", out});
  REQUIRE(says(out, "\"state\": \"starting\""));
  CHECK(contains(tell(out, "pause").out, "\"state\": \"paused\""));
  CHECK(contains(tell(out, "home").out, "\"purpose\": \"returning\""));
  CHECK(contains(tell(out, "resume").out, "\"state\": \"returning\""));
  CHECK(program.finish(std::chrono::seconds(60)).exit_code == 0);
  CHECK(contains(read_plain(out + "/report.json"), "\"state\": \"home\""));
}

TEST_CASE("a script's words come at their times, the same in every run", "[system][control]") {
  const TempFolder folder;
  const std::vector<std::string> arguments{"sim",  "--world", "house", "--robots", "1",    "--camera",  "160x120@10",
                                           "--at", "45:home", "--at",  "20:pause", "--at", "30:resume", "--quiet"};
  std::string hash;
  for (const char* name : {"a", "b"}) {
    std::vector<std::string> run = arguments;
    run.insert(run.end(), {"--out", folder / name});
    const ProgramResult result = run_g3dmap(run);
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    const std::string report = folder / name + std::string("/report.json");
    CHECK(contains(read_plain(report), "\"state\": \"home\""));
    CHECK(way_between(folder / name + std::string("/trajectory.tum"), 20.8, 30.0) < 0.005);
    CHECK(way_between(folder / name + std::string("/trajectory.tum"), 30.0, 40.0) > 0.5);
    if (!hash.empty()) CHECK(report_text(report, "hash") == hash);
    hash = report_text(report, "hash");
  }
}
