// SPDX-License-Identifier: Apache-2.0
// Odometry that drifts, from the command line: corrected, and told about.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "hal/replay/trajectory_file.hpp"
#include "tests/support/log_folder.hpp"
#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"
#include "tests/support/trajectory_error.hpp"

using namespace g3d;
using namespace g3d::test;

namespace {

std::vector<hal::StampedPose> way_in(const std::string& file) {
  const auto poses = hal::read_trajectory(file);
  REQUIRE(poses.ok());
  return poses.value();
}

/// Eight seconds of the furnished room at 5 Hz.
std::string fly(const TempFolder& folder, const std::string& name, std::vector<std::string> extra) {
  const std::string out = folder / name;
  std::vector<std::string> arguments{"sim",          "--fps", "5",       "--duration", "8",
                                     "--resolution", "0.05",  "--quiet", "--out",      out};
  arguments.insert(arguments.end(), extra.begin(), extra.end());
  const ProgramResult result = run_g3dmap(arguments);
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  return out;
}

}  // namespace

TEST_CASE("a flight whose odometry drifts is corrected, and both ways are kept", "[system][align]") {
  const TempFolder folder;
  const auto truth = way_in(fly(folder, "exact", {}) + "/trajectory.tum");
  const std::string drifting = fly(folder, "drifting", {"--drift", "1"});
  const std::string aligned = fly(folder, "aligned", {"--drift", "1", "--odometry", "aligned"});
  const double drifted_m = trajectory_error(truth, way_in(drifting + "/trajectory.tum")).ate_m;
  const double aligned_m = trajectory_error(truth, way_in(aligned + "/trajectory.tum")).ate_m;
  CHECK(drifted_m > 0.03);
  CHECK(aligned_m < 0.3 * drifted_m);
  CHECK(trajectory_error(truth, way_in(aligned + "/odometry.tum")).ate_m == Approx(drifted_m).epsilon(1e-6));
  CHECK_FALSE(std::filesystem::exists(drifting + "/odometry.tum"));
  CHECK(report_number(aligned + "/report.json", "aligned") > 35);
  CHECK(report_text(aligned + "/report.json", "odometry") == "aligned");
  CHECK(report_is_balanced(aligned + "/report.json"));

  // The same seed and the same frames: the same map, for any number of threads.
  const std::string again =
      fly(folder, "again", {"--drift", "1", "--odometry", "aligned", "--threads", "2", "--no-colour"});
  CHECK(trajectory_error(way_in(aligned + "/trajectory.tum"), way_in(again + "/trajectory.tum")).ate_m == 0.0);
}

TEST_CASE("where nothing is seen again, looking for it changes neither map nor way", "[system][align]") {
  const TempFolder folder;
  const std::string plain = fly(folder, "plain", {"--drift", "1", "--odometry", "aligned"});
  const std::string looped = fly(folder, "looped", {"--drift", "1", "--odometry", "aligned", "--loops"});
  CHECK(report_text(plain + "/report.json", "hash") == report_text(looped + "/report.json", "hash"));
  CHECK(trajectory_error(way_in(plain + "/trajectory.tum"), way_in(looped + "/trajectory.tum")).ate_m == 0.0);
  CHECK(report_number(looped + "/report.json", "submaps") >= 1);
  CHECK(report_number(looped + "/report.json", "corrections") == 0);
  CHECK(report_number(looped + "/report.json", "refused_blocks") == 0);
}

TEST_CASE("poses of a recording drift by seed, and files that are none are refused by name", "[system][align]") {
  const TempFolder folder;
  const std::string log = folder / "log";
  write_log(log, {});
  const std::string out = folder / "odometry.tum";
  REQUIRE(run_g3dmap({"drift", log, "--seed", "3", "--out", out}).exit_code == 0);
  const auto once = way_in(out);
  REQUIRE(run_g3dmap({"drift", log, "--seed", "3", "--out", out}).exit_code == 0);
  CHECK(way_in(out).back().T_world_camera.translation_m == once.back().T_world_camera.translation_m);
  const ProgramResult mapped =
      run_g3dmap({"replay", log, "--poses", out, "--odometry", "aligned", "--quiet", "--out", folder / "out"});
  INFO(mapped.err);
  CHECK(mapped.exit_code == 0);

  const ProgramResult missing = run_g3dmap({"drift", folder / "nowhere", "--out", out});
  CHECK(missing.exit_code == 1);
  CHECK(missing.err.find("nowhere") != std::string::npos);
  const ProgramResult no_poses = run_g3dmap({"drift", log + "/depth.txt", "--out", out});
  CHECK(no_poses.exit_code == 1);
  CHECK(no_poses.err.find("depth.txt:") != std::string::npos);
}

TEST_CASE("without odometry a recording is followed by its frames, from where it began", "[system][align]") {
  const TempFolder folder;
  const std::string log = folder / "log";
  write_log(log, {});
  const std::string out = folder / "out";
  const ProgramResult result =
      run_g3dmap({"replay", log, "--odometry", "none", "--motion", "free", "--quiet", "--out", out});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(report_text(out + "/report.json", "motion") == "free");
  CHECK_FALSE(way_in(out + "/trajectory.tum").empty());
}

TEST_CASE("what alignment cannot do is bad usage, with the reason", "[system][align]") {
  const TempFolder folder;
  CHECK(run_g3dmap({"sim", "--robots", "1", "--odometry", "none", "--out", folder / "a"}).exit_code == 2);
  CHECK(run_g3dmap({"sim", "--robots", "1", "--motion", "free", "--out", folder / "a"}).exit_code == 2);
  CHECK(run_g3dmap({"sim", "--odometry", "guessed", "--out", folder / "a"}).exit_code == 2);
}

TEST_CASE("maps whose poses are off are fitted before they are merged, or refused", "[system][align]") {
  const TempFolder folder;
  const std::string room = fly(folder, "room", {}) + "/map.g3d";
  const std::string other = fly(folder, "office", {"--world", "office"}) + "/map.g3d";
  const std::string out = folder / "both.g3d";
  const std::vector<std::string> off{"--pose", "0,0,0,0,0,0", "--pose", "0.4,-0.2,0,0,0,0.2", "--out", out};

  std::vector<std::string> arguments{"merge", room, room, "--align", "rough"};
  arguments.insert(arguments.end(), off.begin(), off.end());
  const ProgramResult fitted = run_g3dmap(arguments);
  INFO(fitted.out << fitted.err);
  REQUIRE(fitted.exit_code == 0);
  CHECK(fitted.out.find("% of") != std::string::npos);
  // The room stands once, not twice: hardly more voxels than in either half.
  const ProgramResult info = run_g3dmap({"info", out, "--json"});
  const auto occupied = [](const std::string& json) {
    return std::stoul(json.substr(json.find("\"occupied\": ") + 12));
  };
  const auto single = occupied(run_g3dmap({"info", room, "--json"}).out);
  CHECK(static_cast<double>(occupied(info.out)) < 1.15 * static_cast<double>(single));

  std::filesystem::remove(out);
  const ProgramResult refused = run_g3dmap({"merge", room, other, "--align", "rough", "--out", out});
  CHECK(refused.exit_code == 1);
  CHECK(refused.err.find("does not fit") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(out));
  CHECK(run_g3dmap({"merge", room, other, "--align", "perhaps", "--out", out}).exit_code == 2);
}

TEST_CASE("a robot that looks for loops goes the same way every time, and says what became of them",
          "[system][align]") {
  const TempFolder folder;
  const auto explore = [&](const std::string& name) {
    const ProgramResult result =
        run_g3dmap({"sim",    "--robots",   "1",          "--world", "lab",     "--camera", "80x60@10",
                    "--seed", "2",          "--duration", "40",      "--drift", "1",        "--drift-like",
                    "rough",  "--odometry", "aligned",    "--loops", "--quiet", "--out",    folder / name});
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    return (folder / name) + "/report.json";
  };
  const std::string once = explore("once");
  const std::string again = explore("again");
  CHECK(report_text(once, "hash") == report_text(again, "hash"));
  CHECK(report_number(once, "submaps") >= 3);
  CHECK(report_number(once, "submaps") == report_number(again, "submaps"));
  CHECK(report_number(once, "refused_blocks") == 0);
  CHECK(report_is_balanced(once));
  CHECK(trajectory_error(way_in(folder / "once/trajectory.tum"), way_in(folder / "again/trajectory.tum")).ate_m == 0.0);
}
