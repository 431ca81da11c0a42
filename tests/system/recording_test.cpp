// SPDX-License-Identifier: Apache-2.0
// `g3dmap run --record` and `replay` of what it wrote: the same map, to the bit; and recordings that ended badly.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "hal/replay/tum_folder.hpp"
#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::test;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::vector<std::string> recorded_run(const TempFolder& folder, const std::vector<std::string>& more) {
  write_plain(folder / "b.toml",
              "name = \"recorded\"\n[map]\nresolution_m = 0.08\nthreads = 1\nmemory_mb = 64\nmiss = 3\n");
  std::vector<std::string> all{"run",      "--board",  folder / "b.toml", "--world", "two_rooms",    "--camera",
                               "80x60@10", "--record", folder / "log",    "--out",   folder / "out", "--quiet"};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

ProgramResult replay(const TempFolder& folder, const std::vector<std::string>& more = {}) {
  std::vector<std::string> all{"replay", folder / "log", "--out", folder / "again", "--quiet"};
  all.insert(all.end(), more.begin(), more.end());
  return run_g3dmap(all);
}

std::size_t lines_of(const std::string& path) {
  const std::string text = read_plain(path);
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace

TEST_CASE("a recorded run is replayed to the same map, however its poses came about", "[system][record][waits]") {
  const std::vector<std::vector<std::string>> ways{
      {}, {"--drift", "1", "--odometry", "aligned"}, {"--no-colour", "--resolution", "0.05"}};
  for (const std::vector<std::string>& way : ways) {
    INFO((way.empty() ? "" : way.front()));
    const TempFolder folder;
    std::vector<std::string> more = way;
    more.insert(more.end(), {"--duration", "5"});
    const ProgramResult run = run_g3dmap(recorded_run(folder, more));
    INFO(run.err);
    REQUIRE(run.exit_code == 0);
    const std::string report = folder / "out/report.json", again = folder / "again/report.json";
    CHECK(contains(read_plain(report), "\"repeatable\": true"));
    CHECK(report_number(report, "poses") == report_number(report, "integrated"));
    CHECK(report_number(report, "written") == report_number(report, "delivered"));
    CHECK(lines_of(folder / "log/depth.txt") == report_number(report, "delivered"));
    CHECK(std::filesystem::file_size(folder / "log/kobuki.bin") > 1000);

    const ProgramResult replayed = replay(folder);
    INFO(replayed.err);
    REQUIRE(replayed.exit_code == 0);
    CHECK(report_text(again, "hash") == report_text(report, "hash"));
    CHECK(report_number(again, "integrated") == report_number(report, "integrated"));
    CHECK(contains(read_plain(again), "to the last bit"));
    CHECK(contains(read_plain(again), "\"board\": \"recorded\""));
  }
}

TEST_CASE("a map that cannot be the run's own is said to be another one, and why", "[system][record][waits]") {
  const TempFolder folder;
  REQUIRE(run_g3dmap(recorded_run(folder, {"--duration", "3"})).exit_code == 0);
  const std::string report = folder / "out/report.json", again = folder / "again/report.json";
  REQUIRE(replay(folder, {"--resolution", "0.1"}).exit_code == 0);
  CHECK(report_text(again, "hash") != report_text(report, "hash"));
  CHECK(contains(read_plain(again), "is not that of the recorded run"));
  CHECK(contains(read_plain(again), "other options"));
  // A frame is gone.
  const auto log = hal::TumFolder::open(folder / "log");
  REQUIRE(log.ok());
  std::filesystem::remove(log.value().frames[log.value().frames.size() / 2].depth_path);
  REQUIRE(replay(folder).exit_code == 0);
  CHECK(contains(read_plain(again), "frames were mapped here and"));
  // A second recording must not be mixed into the first.
  const ProgramResult second = run_g3dmap(recorded_run(folder, {"--duration", "1"}));
  CHECK(second.exit_code == 1);
  CHECK(contains(second.err, "there is a recording already"));
}

TEST_CASE("a run that corrects its whole map says that the recording does not repeat it", "[system][record][waits]") {
  const TempFolder folder;
  const ProgramResult run = run_g3dmap(recorded_run(folder, {"--odometry", "aligned", "--loops", "--duration", "2"}));
  INFO(run.err);
  REQUIRE(run.exit_code == 0);
  CHECK(contains(read_plain(folder / "out/report.json"), "\"repeatable\": false"));
  CHECK(contains(read_plain(folder / "log/mapped.txt"), "cannot the whole map was corrected"));
}

TEST_CASE("a run that is killed while it records leaves a recording that can be mapped", "[system][record][waits]") {
  const TempFolder folder;
  Program run(g3dmap_path(), recorded_run(folder, {}));
  const std::string list = folder / "log/depth.txt", way = folder / "log/trajectory.tum";
  for (int i = 0; i < 3000 && !(std::filesystem::exists(way) && lines_of(way) >= 10); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  run.send(SIGKILL);
  (void)run.finish();
  const std::size_t listed = lines_of(list);
  REQUIRE(listed >= 10);
  const ProgramResult replayed = replay(folder);
  INFO(replayed.err);
  CHECK(replayed.exit_code == 0);
  const std::string again = folder / "again/report.json";
  CHECK(report_number(again, "delivered") == listed);
  CHECK(report_number(again, "integrated") >= 10);
  CHECK(contains(read_plain(again), "did not come to its end"));
}

TEST_CASE("a disk that is full costs the recording and not the drive, and that is said", "[system][record][waits]") {
  const TempFolder folder;
  const ProgramResult run =
      run_g3dmap(recorded_run(folder, {"--duration", "5", "--fail", "disk:intermittent@1+3", "--patience", "30"}));
  INFO(run.err);
  CHECK(run.exit_code == 1);
  CHECK(contains(run.err, "the recording has a gap"));
  const std::string report = folder / "out/report.json";
  CHECK(contains(read_plain(report), "\"repeatable\": false"));
  CHECK(contains(read_plain(report), "the disk refused"));
  CHECK(report_number(report, "integrated") > 5);
  CHECK(report_number(report, "written") < report_number(report, "delivered"));
  CHECK(contains(read_plain(report), "\"stands\": true"));
  CHECK(replay(folder).exit_code == 0);
  CHECK_FALSE(contains(read_plain(folder / "again/report.json"), "to the last bit"));
}
