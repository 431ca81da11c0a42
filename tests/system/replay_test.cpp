// SPDX-License-Identifier: Apache-2.0
// `g3dmap replay` as a user runs it: good recordings, and every kind of spoiled one.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "hal/kobuki/odometry.hpp"
#include "hal/replay/kobuki_log.hpp"
#include "hal/replay/trajectory_file.hpp"
#include "mapper/files/any_map.hpp"
#include "mapper/map_hash.hpp"
#include "tests/support/kobuki_packets.hpp"
#include "tests/support/log_folder.hpp"
#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::test;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// A recording and a run of it; `spoil` works on the recording before.
struct Replay {
  template <typename Spoil>
  explicit Replay(Spoil spoil, std::vector<std::string> extra = {}, LogSpec log_spec = {}) : spec(log_spec) {
    write_log(log, spec);
    spoil(*this);
    std::vector<std::string> arguments{"replay", log, "--out", out, "--quiet"};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    result = run_g3dmap(arguments);
  }
  Replay() : Replay([](Replay&) {}) {}
  [[nodiscard]] std::uint64_t reported(const std::string& key) const {
    return report_number(out + "/report.json", key);
  }
  [[nodiscard]] bool balanced() const { return report_is_balanced(out + "/report.json"); }

  TempFolder folder;
  LogSpec spec;
  std::string log = folder / "log";
  std::string out = folder / "out";
  ProgramResult result;
};

void truncate_file(const std::string& path) {
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
}

}  // namespace

TEST_CASE("a recording becomes every file that is promised", "[system][replay]") {
  const Replay run;
  INFO(run.result.err);
  REQUIRE(run.result.exit_code == 0);
  for (const char* name : {"map.g3d", "map.ot", "map.bt", "map.ply", "ground.pgm", "ground.yaml", "trajectory.tum",
                           "map.png", "report.json"}) {
    CHECK(std::filesystem::file_size(run.out + "/" + name) > 0);
  }
  CHECK(run.reported("delivered") == 12);
  CHECK(run.reported("integrated") == 12);
  CHECK(run.balanced());
  const auto map = g3d::mapper::read_any_map(run.out + "/map.g3d");
  REQUIRE(map.ok());
  CHECK(map.value().map->counts().occupied == run.reported("occupied"));
  CHECK(map.value().map->counts().coloured > 0);
  CHECK(report_text(run.out + "/report.json", "hash") == map_hash(*map.value().map));
}

TEST_CASE("the same recording gives the same map for any number of threads", "[system][replay]") {
  std::string hash;
  for (const char* threads : {"1", "2", "3"}) {
    const Replay run([](Replay&) {}, {"--threads", threads});
    REQUIRE(run.result.exit_code == 0);
    const std::string here = report_text(run.out + "/report.json", "hash");
    CHECK(here.size() == 64);
    if (hash.empty()) hash = here;
    CHECK(here == hash);
  }
}

TEST_CASE("real time keeps the recording's pace", "[system][replay][waits]") {
  const Replay run([](Replay&) {}, {"--rate", "2"});
  REQUIRE(run.result.exit_code == 0);
  CHECK(run.reported("delivered") == 12);
  CHECK(run.balanced());
}

TEST_CASE("a missing, a truncated and a lying depth image are counted drops", "[system][replay]") {
  const Replay run([](Replay& r) {
    std::filesystem::remove(log_depth_path(r.log, 2));
    truncate_file(log_depth_path(r.log, 4));
    std::ofstream(log_depth_path(r.log, 6), std::ios::binary) << "this is no picture";
  });
  CHECK(run.result.exit_code == 0);
  CHECK(run.reported("unreadable_depth") == 3);
  CHECK(run.reported("integrated") == 9);
  CHECK(run.balanced());
}

TEST_CASE("a depth image of another size is a counted drop", "[system][replay]") {
  const Replay run([](Replay& r) {
    const TempFolder other;
    write_log(other.path(), {.frames = 1, .width_px = 32, .height_px = 24});
    std::filesystem::copy_file(log_depth_path(other.path(), 0), log_depth_path(r.log, 3),
                               std::filesystem::copy_options::overwrite_existing);
  });
  CHECK(run.result.exit_code == 0);
  CHECK(run.reported("wrong_size") == 1);
  CHECK(run.reported("integrated") == 11);
  CHECK(run.balanced());
}

TEST_CASE("poses with NaN and times without a pose are counted drops", "[system][replay]") {
  const Replay run([](Replay& r) {
    // Line 0 is the pose before the first frame, so frame 5's own is line 6.
    replace_log_line(r.log + "/groundtruth.txt", 6, log_stamp(r.spec, 5) + " nan 0 1 0 0 0 1");
    replace_log_line(r.log + "/depth.txt", 11, "1305039999.5 depth/0011.png");
  });
  CHECK(run.result.exit_code == 0);
  CHECK(run.reported("bad_pose") == 1);
  CHECK(run.reported("no_pose") == 1);
  CHECK(run.reported("integrated") == 10);
  CHECK(run.balanced());
}

TEST_CASE("frames whose time runs backwards are counted drops", "[system][replay]") {
  const Replay run([](Replay& r) {
    replace_log_line(r.log + "/depth.txt", 7, log_stamp(r.spec, 3) + " depth/0007.png");
    replace_log_line(r.log + "/depth.txt", 8, log_stamp(r.spec, 6) + " depth/0008.png");
  });
  CHECK(run.result.exit_code == 0);
  CHECK(run.reported("time_backwards") == 2);
  CHECK(run.balanced());
}

TEST_CASE("a recording without frames is a clear error", "[system][replay]") {
  const Replay run([](Replay& r) { std::ofstream(r.log + "/depth.txt") << "# nothing\n"; });
  CHECK(run.result.exit_code == 1);
  CHECK(contains(run.result.err, "frames"));
}

TEST_CASE("a folder that is not there is a clear error", "[system][replay]") {
  const TempFolder folder;
  const ProgramResult result = run_g3dmap({"replay", folder / "nothing", "--out", folder / "out"});
  CHECK(result.exit_code == 1);
  CHECK(contains(result.err, "nothing"));
}

TEST_CASE("an output folder that cannot be made is a clear error", "[system][replay]") {
  const Replay in_the_way([](Replay& r) { std::ofstream(r.out) << "a file where the folder should be"; });
  CHECK(in_the_way.result.exit_code == 1);
  CHECK(contains(in_the_way.result.err, in_the_way.out));
  const TempFolder folder;
  write_log(folder / "log", {.frames = 2});
  const ProgramResult read_only = run_g3dmap({"replay", folder / "log", "--out", "/proc/g3dmap_out"});
  CHECK(read_only.exit_code == 1);
  CHECK(contains(read_only.err, "/proc/g3dmap_out"));
}

TEST_CASE("poses from another file replace the recording's own", "[system][replay]") {
  const Replay run([](Replay& r) { std::filesystem::rename(r.log + "/groundtruth.txt", r.folder / "elsewhere.tum"); },
                   {});
  CHECK(run.result.exit_code == 1);  // no trajectory in the folder
  const ProgramResult result =
      run_g3dmap({"replay", run.log, "--poses", run.folder / "elsewhere.tum", "--out", run.out, "--quiet"});
  CHECK(result.exit_code == 0);
  CHECK(run.reported("integrated") == 12);
}

TEST_CASE("without poses the base's bytes give them", "[system][replay]") {
  // Half a metre ahead while the frames are taken, and some noise on the line.
  const auto record_base = [](Replay& r) {
    std::filesystem::remove(r.log + "/groundtruth.txt");
    g3d::hal::kobuki::Feedback packet = g3d::tests::first_packet();
    std::vector<std::uint8_t> file;
    const auto first_ns = static_cast<g3d::hal::TimeNs>(1e9 * std::stod(log_stamp(r.spec, 0))) - 20'000'000;
    for (int i = 0; i < 25; ++i) {
      std::vector<std::uint8_t> bytes = g3d::tests::frame_of(packet);
      if (i == 3) bytes.insert(bytes.begin(), {0xAA, 0x55, 0x07});
      g3d::hal::append_record(file, first_ns + i * g3d::hal::kobuki::kPacketPeriod_ns, bytes);
      packet = g3d::tests::packet_after(packet, 230, 230);
    }
    write_plain(r.log + "/kobuki.bin", std::span<const std::uint8_t>(file));
  };
  const Replay run(record_base, {"--board", "board/kobuki_tx2.toml", "--resolution", "0.05", "--window", "0"});
  INFO(run.result.err);
  REQUIRE(run.result.exit_code == 0);
  CHECK(run.reported("integrated") == 12);
  CHECK(run.balanced());
  CHECK(contains(read_plain(run.out + "/report.json"), "poses from the base's odometry: 25 packets, 0.4"));
  const auto way = g3d::hal::read_trajectory(run.out + "/trajectory.tum");
  REQUIRE(way.ok());
  REQUIRE(way.value().size() == 12);
  const g3d::hal::Pose& last = way.value().back().T_world_camera;
  CHECK(last.translation_m[2] == Approx(0.297));  // as the board has it mounted
  CHECK(last.translation_m[0] - way.value().front().T_world_camera.translation_m[0] ==
        Approx(11.0 / 30.0 * 230 * 50 * g3d::hal::kobuki::kMetresPerTick).epsilon(0.02));

  const Replay own([&](Replay& r) {
    record_base(r);
    std::ofstream(r.log + "/trajectory.tum") << "1.0 0 0 0 0 0 0 1\n";  // the recording's own poses come first
  });
  CHECK(own.reported("no_pose") == 12);
  const Replay nothing([&](Replay& r) {
    std::filesystem::remove(r.log + "/groundtruth.txt");
    std::vector<std::uint8_t> file;
    g3d::hal::append_record(file, 1, std::vector<std::uint8_t>(300, 0x55));
    write_plain(r.log + "/kobuki.bin", std::span<const std::uint8_t>(file));
  });
  CHECK(nothing.result.exit_code == 1);
  CHECK(contains(nothing.result.err, "kobuki.bin: not one good packet"));
}

TEST_CASE("a wall view becomes a mask that replay takes", "[system][replay][mask]") {
  const Replay run;
  const std::string mask = run.folder / "mask.png";
  const ProgramResult made = run_g3dmap({"mask", run.log, "--out", mask});
  INFO(made.err);
  REQUIRE(made.exit_code == 0);
  const ProgramResult used = run_g3dmap({"replay", run.log, "--mask", mask, "--out", run.out, "--quiet"});
  CHECK(used.exit_code == 0);
  const ProgramResult wrong = run_g3dmap({"replay", run.log, "--mask", run.log + "/rgb/0000.png", "--out", run.out});
  CHECK(wrong.exit_code == 1);
  CHECK(contains(wrong.err, "0000.png"));
}

TEST_CASE("a real recording is mapped, frame by frame", "[system][replay]") {
  const std::string data = data_folder();
  if (data.empty()) return;
  const TempFolder folder;
  const ProgramResult result =
      run_g3dmap({"replay", data + "/rgbd_tum_fr1_rpy", "--threads", "2", "--out", folder.path(), "--quiet"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(report_number(folder / "report.json", "delivered") == 150);
  CHECK(report_is_balanced(folder / "report.json"));
  CHECK(report_number(folder / "report.json", "occupied") > 10000);
}
