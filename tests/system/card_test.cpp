// SPDX-License-Identifier: Apache-2.0
// A robot whose map is computed in a card, when the helper process dies or hangs under way. The card is one that is
// none (tests/fake_cuda), so that this runs on every machine.
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/fake_card.hpp"
#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::test;

namespace {

namespace fs = std::filesystem;

constexpr const char* kRoom =
    "room 0 0 0  7 4 2.5 0.1\n"
    "box 0 -1.3 0  0.1 1.4 2.5\n"
    "box 0 1.05 0  0.1 1.9 2.5\n"
    "start -2 -0.5 60\n";

/// The helper process of this program; -1: there is none at the moment.
int helper_of(int pid) {
  std::error_code ignored;
  for (const auto& thread : fs::directory_iterator("/proc/" + std::to_string(pid) + "/task", ignored)) {
    std::ifstream children(thread.path() / "children");
    int child = 0;
    while (children >> child) {
      const fs::path program = fs::read_symlink("/proc/" + std::to_string(child) + "/exe", ignored);
      if (program.string().find("g3dmap-helper") != std::string::npos) return child;
    }
  }
  return -1;
}

/// Once the robot listens to commands, and so the card was found: sends every helper this signal some time after it has
/// come up. How many it met.
int hit_helpers(Program& program, const std::string& control, int signal, std::chrono::milliseconds after) {
  while (program.is_running() && !fs::exists(control)) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  int count = 0, last = -1;
  while (program.is_running()) {
    const int helper = helper_of(program.pid());
    if (helper < 0 || helper == last) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      continue;
    }
    std::this_thread::sleep_for(after + std::chrono::milliseconds(7 * (count % 9)));
    if (kill(helper, signal) == 0) ++count;
    last = helper;
  }
  return count;
}

std::vector<std::string> command(const TempFolder& folder, const std::string& kind, const std::string& out,
                                 const std::vector<std::string>& more) {
  write_plain(folder / "room.world", kRoom);
  write_plain(folder / "small.toml", "name = \"small\"\n[map]\nresolution_m = 0.1\nthreads = 1\nmemory_mb = 64\n");
  std::vector<std::string> arguments{
      kind,      "--board", folder / "small.toml", "--world",   folder / "room.world", "--camera", "160x120@10",
      "--quiet", "--out",   folder / out,          "--control", folder / "control"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

}  // namespace

TEST_CASE("a card that dies again and again changes neither map nor way", "[system][card]") {
  const TempFolder folder;
  const std::vector<std::string> alone{"--robots", "1", "--duration", "200"};
  auto arguments = alone;
  arguments.insert(arguments.end(), {"--mapper", "cpu"});
  REQUIRE(run_g3dmap(command(folder, "sim", "undisturbed", arguments)).exit_code == 0);
  const FakeCard card(FakeDriver::works);
  arguments = alone;
  arguments.insert(arguments.end(), {"--mapper", "cuda"});
  Program program(g3dmap_path(), command(folder, "sim", "killed", arguments));
  const int kills = hit_helpers(program, folder / "control", SIGKILL, std::chrono::milliseconds(40));
  const ProgramResult result = program.finish();
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CAPTURE(kills);
  CHECK(kills >= 3);
  const std::string report = folder / "killed/report.json";
  CHECK(read_plain(report).find("the card was lost ") != std::string::npos);
  CHECK(report_is_balanced(report));
  CHECK(report_text(report, "hash") == report_text(folder / "undisturbed/report.json", "hash"));
  CHECK(read_plain(folder / "killed/trajectory.tum") == read_plain(folder / "undisturbed/trajectory.tum"));
}

TEST_CASE("in real time a robot whose card dies or hangs goes on and touches nothing", "[system][card]") {
  const int signal = GENERATE(SIGKILL, SIGSTOP);
  const TempFolder folder;
  const FakeCard card(FakeDriver::works);
  Program program(g3dmap_path(), command(folder, "run", "out", {"--duration", "8", "--mapper", "cuda"}));
  const int hits = hit_helpers(program, folder / "control", signal, std::chrono::milliseconds(900));
  const ProgramResult result = program.finish();
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(hits >= 2);
  const std::string report = folder / "out/report.json";
  CHECK(report_is_balanced(report));
  CHECK(report_number(report, "integrated") > 30);
  CHECK(report_number(report, "collisions") == 0);
}
