// SPDX-License-Identifier: Apache-2.0
// Folders that may not be written, disks that are full, and a process that is killed between two checkpoints: a clear
// error names the file, and what was saved stays whole.
#include <sys/mount.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "mapper/files/any_map.hpp"
#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::test;
namespace fs = std::filesystem;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::vector<std::string> short_flight(const std::string& out, const std::string& resolution) {
  return {"sim", "--duration", "0.2", "--resolution", resolution, "--quiet", "--out", out};
}

/// A disk of its own in a folder; root alone can make one.
class SmallDisk {
 public:
  SmallDisk(std::string path, const std::string& size) : path_(std::move(path)) {
    fs::create_directories(path_);
    mounted_ = mount("tmpfs", path_.c_str(), "tmpfs", 0, ("size=" + size).c_str()) == 0;
  }
  ~SmallDisk() {
    if (mounted_) umount2(path_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  [[nodiscard]] bool mounted() const { return mounted_; }

 private:
  std::string path_;
  bool mounted_ = false;
};

}  // namespace

TEST_CASE("a folder that may not be written is a clear error at once", "[system][disk]") {
  const TempFolder folder;
  const std::string out = folder / "out";
  fs::create_directories(out);
  for (const std::string& path : {folder.path(), out}) {
    fs::permissions(path,
                    fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_read | fs::perms::others_exec);
  }
  const ProgramResult existing = run_g3dmap(short_flight(out, "0.1"), {.no_root = true});
  CHECK(existing.exit_code == 1);
  CHECK(contains(existing.err, out));
  const ProgramResult missing = run_g3dmap(short_flight(folder.path() + "/new", "0.1"), {.no_root = true});
  CHECK(missing.exit_code == 1);
  CHECK(contains(missing.err, folder.path() + "/new"));
  for (const std::string& path : {folder.path(), out}) fs::permissions(path, fs::perms::owner_all);
  CHECK(fs::is_empty(out));
}

TEST_CASE("where the map fits but the point cloud does not, the map is saved", "[system][disk]") {
  const TempFolder folder;
  const std::string whole = folder / "whole";
  REQUIRE(run_g3dmap(short_flight(whole, "0.05")).exit_code == 0);
  const std::uint64_t limit_bytes = fs::file_size(whole + "/map.g3d") + 1000;
  REQUIRE(fs::file_size(whole + "/map.ply") > limit_bytes);
  const std::string out = folder / "out";
  const ProgramResult cut = run_g3dmap(short_flight(out, "0.05"), {.file_size_bytes = limit_bytes});
  CHECK(cut.exit_code == 1);
  CHECK(contains(cut.err, "map.ply"));
  CHECK(read_plain(out + "/map.g3d") == read_plain(whole + "/map.g3d"));
  CHECK_FALSE(fs::exists(out + "/map.ply"));
  CHECK_FALSE(fs::exists(out + "/map.ply.part"));
  CHECK(report_is_balanced(out + "/report.json"));
}

TEST_CASE("a full disk leaves the old map as it was", "[system][disk]") {
  const TempFolder folder;
  const std::string out = folder / "disk";
  const SmallDisk disk(out, "2m");
  if (!disk.mounted()) {
    WARN("no right to mount a small disk here; the limit on file sizes stands for it");
    return;
  }
  REQUIRE(run_g3dmap(short_flight(out, "0.2")).exit_code == 0);
  const std::string old_map = read_plain(out + "/map.g3d");
  const std::uint64_t room_bytes = fs::space(out).available;
  const std::string filler(room_bytes > 40'000 ? room_bytes - 40'000 : 0, 'x');
  write_plain(out + "/filler", filler);
  const ProgramResult full = run_g3dmap(short_flight(out, "0.02"));
  CHECK(full.exit_code == 1);
  CHECK(contains(full.err, "map.g3d"));
  CHECK(contains(full.err, "space"));
  CHECK(read_plain(out + "/map.g3d") == old_map);
  CHECK_FALSE(fs::exists(out + "/map.g3d.part"));
}

TEST_CASE("a killed run leaves the last checkpoint", "[system][checkpoint]") {
  for (const int more_ms : {0, 30, 170}) {
    const TempFolder folder;
    Program program(g3dmap_path(), {"sim", "--rate", "1", "--resolution", "0.05", "--checkpoint", "0.05", "--quiet",
                                    "--out", folder.path()});
    for (int i = 0; i < 4000 && !fs::exists(folder / "map.g3d"); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(more_ms));
    REQUIRE(program.is_running());
    program.send(SIGKILL);
    CHECK(program.finish().signal == SIGKILL);
    const auto map = g3d::mapper::read_any_map(folder / "map.g3d");
    REQUIRE(map.ok());
    CHECK_FALSE(fs::exists(folder / "report.json"));
  }
}

TEST_CASE("checkpoints do not change the map", "[system][checkpoint]") {
  const TempFolder folder;
  std::vector<std::string> with = short_flight(folder / "with", "0.05");
  with.insert(with.end(), {"--checkpoint", "0.01"});
  REQUIRE(run_g3dmap(with).exit_code == 0);
  REQUIRE(run_g3dmap(short_flight(folder / "without", "0.05")).exit_code == 0);
  CHECK(read_plain(folder / "with/map.g3d") == read_plain(folder / "without/map.g3d"));
  CHECK(contains(read_plain(folder / "with/report.json"), "map.g3d was saved at "));
  const ProgramResult both = run_g3dmap(
      {"sim", "--checkpoint", "1", "--window", "5", "--duration", "0.1", "--quiet", "--out", folder / "both"});
  CHECK(both.exit_code == 2);
  CHECK(contains(both.err, "--checkpoint"));
}

TEST_CASE("the robot's place is free from the start where that is asked for", "[system][footprint]") {
  const TempFolder folder;
  const auto known_free = [&](const std::string& footprint) {
    std::vector<std::string> arguments = short_flight(folder / "out", "0.05");
    if (!footprint.empty()) arguments.insert(arguments.end(), {"--footprint", footprint});
    const ProgramResult result = run_g3dmap(arguments);
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    return report_number(folder / "out/report.json", "free");
  };
  // The nearest 0.8 m are out of the camera's sight, so the cylinder of 0.3 m adds all its voxels.
  const double plain = static_cast<double>(known_free(""));
  const double cylinder_voxels = 3.14159 * 0.3 * 0.3 * 0.5 / (0.05 * 0.05 * 0.05);
  CHECK(static_cast<double>(known_free("0.3,0.5")) - plain > 0.8 * cylinder_voxels);
  CHECK(static_cast<double>(known_free("0.3,0.5")) - plain < 1.6 * cylinder_voxels);
  CHECK(static_cast<double>(known_free("board")) > plain);
  for (const char* bad : {"0.3", "0.3,", "x,1", "-1,1", "0.3,nan", "0.3,50", "0,1", "0.3,0.5,1"}) {
    std::vector<std::string> arguments = short_flight(folder / "bad", "0.05");
    arguments.insert(arguments.end(), {"--footprint=" + std::string(bad)});
    CHECK(run_g3dmap(arguments).exit_code == 2);
  }
}
