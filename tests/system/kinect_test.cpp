// SPDX-License-Identifier: Apache-2.0
// The way from a Kinect's driver to frames, for as long as it takes to trust it; and `g3dmap` with recordings and with
// the virtual Kinect as a user starts it.
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "hal/frame_pool.hpp"
#include "hal/kinect/openni_parts.hpp"
#include "tests/support/oni_builder.hpp"
#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::test;

namespace {

bool has_openni() {
  if (hal::kinect::is_openni_built_in()) return true;
  WARN("this g3dmap was built without OpenNI2");
  return false;
}

std::string kinect_recording() {
  const std::string data = data_folder();
  return data.empty() ? data : data + "/oni/kinect360_12frames.oni";
}

ProgramResult replay_oni(const std::string& file, const std::string& out) {
  return run_g3dmap(
      {"replay", file, "--odometry", "none", "--motion", "free", "--quiet", "--threads", "1", "--out", out});
}

}  // namespace

TEST_CASE("`replay` maps an .oni file; one that is cut off, or has no poses, is refused with what to do", "[system]") {
  if (!has_openni()) return;
  const TempFolder folder;
  const auto good = small_oni(320, 240, 3);
  write_plain(folder / "good.oni", std::span<const std::uint8_t>(good));
  const ProgramResult mapped = replay_oni(folder / "good.oni", folder / "out");
  INFO(mapped.err);
  REQUIRE(mapped.exit_code == 0);
  CHECK(report_number(folder / "out/report.json", "delivered") == 3);
  CHECK(report_number(folder / "out/report.json", "integrated") == 3);
  write_plain(folder / "cut.oni", std::span<const std::uint8_t>(good).first(good.size() - 40));
  const ProgramResult cut = replay_oni(folder / "cut.oni", folder / "out2");
  CHECK(cut.exit_code == 1);
  CHECK_THAT(cut.err, Catch::Contains("cut.oni: byte") && Catch::Contains("cut off"));
  const ProgramResult poseless = run_g3dmap({"replay", folder / "good.oni", "--out", folder / "out3"});
  CHECK(poseless.exit_code == 2);
  CHECK_THAT(poseless.err, Catch::Contains("--poses"));
}

TEST_CASE("a real Kinect's recording is mapped", "[system]") {
  const std::string file = kinect_recording();
  if (!has_openni()) return;
  if (file.empty() || !std::ifstream(file)) {
    WARN("no recordings here: set G3D_DATA to test with them");
    return;
  }
  const TempFolder folder;
  const ProgramResult mapped = replay_oni(file, folder / "out");
  INFO(mapped.err);
  REQUIRE(mapped.exit_code == 0);
  CHECK(report_number(folder / "out/report.json", "delivered") == 12);
  CHECK(report_number(folder / "out/report.json", "integrated") == 12);
  CHECK(report_number(folder / "out/report.json", "occupied") > 1000);
}

TEST_CASE("damaged .oni files never end the program, whatever is wrong with them", "[system]") {
  if (!has_openni()) return;
  const TempFolder folder;
  auto good = small_oni(64, 48, 3);
  std::mt19937 random(3);
  for (int run = 0; run < 12; ++run) {
    auto bad = good;
    for (unsigned i = 0; i <= random() % 4; ++i) {
      bad[random() % bad.size()] ^= static_cast<std::uint8_t>(1U << (random() % 8));
    }
    write_plain(folder / "bad.oni", std::span<const std::uint8_t>(bad));
    const ProgramResult result = replay_oni(folder / "bad.oni", folder / "out");
    INFO(run << ": " << result.err);
    CHECK((result.exit_code == 0 || result.exit_code == 1));
  }
}

TEST_CASE("a robot in a simulated building sees by the virtual Kinect, through all of OpenNI2",
          "[system][run][waits]") {
  if (!has_openni()) return;
  const TempFolder folder;
  write_plain(folder / "k.toml",
              "name = \"k\"\n[camera]\nsource = \"kinect\"\nrate_hz = 5\n[map]\nresolution_m = 0.1\nthreads = 1\n"
              "memory_mb = 64\n");
  const ProgramResult result =
      run_g3dmap({"run", "--board", folder / "k.toml", "--world", "two_rooms", "--duration", "12", "--quiet",
                  "--record-oni", folder / "eyes.oni", "--out", folder / "out"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const std::string report = folder / "out/report.json";
  CHECK(report_number(report, "opened") == 1);
  CHECK(report_number(report, "integrated") > 5);
  CHECK(report_number(report, "bad_depth") == 0);
  CHECK_THAT(read_plain(report), Catch::Contains("\"source\": \"virtual\""));
  const ProgramResult replayed = replay_oni(folder / "eyes.oni", folder / "again");
  INFO(replayed.err);
  CHECK(replayed.exit_code == 0);
  CHECK(report_number(folder / "again/report.json", "integrated") > 5);
}

TEST_CASE("a robot does not drive by a recording, nor by a calibration that cannot be", "[system][run]") {
  const TempFolder folder;
  const auto refused = [&](const std::string& board, int exit_code, const std::string& says) {
    write_plain(folder / "k.toml", board);
    const ProgramResult result = run_g3dmap({"run", "--board", folder / "k.toml", "--quiet"});
    INFO(board << result.err);
    CHECK(result.exit_code == exit_code);
    CHECK_THAT(result.err, Catch::Contains(says));
  };
  refused("[base]\nline = \"/dev/ttyUSB9\"\n[camera]\nsource = \"oni:a.oni\"\n", 2, "somebody else saw");
  refused("[camera]\nsource = \"oni:\"\n", 1, "camera.source");
  if (!has_openni()) return;
  refused("[camera]\nsource = \"oni:/none/a.oni\"\n", 1, "/none/a.oni");
  write_plain(folder / "c.toml", "[colour]\nfx_px = 9\n");
  refused("[camera]\nsource = \"kinect\"\ncalibration = \"" + (folder / "c.toml") + "\"\n", 1, "c.toml:2");
}
