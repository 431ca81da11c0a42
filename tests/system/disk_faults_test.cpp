// SPDX-License-Identifier: Apache-2.0
// The fault matrix's disk, under the built program in real time: the robot drives on as if nothing had happened, and
// what it mapped is saved as soon as the disk takes it; if it never does, that is said.
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "hal/linux/control_socket.hpp"
#include "hal/replay/trajectory_file.hpp"
#include "mapper/files/any_map.hpp"
#include "mapper/map_hash.hpp"
#include "tests/support/fault_cells.hpp"
#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

double number_in(const std::string& json, const std::string& name) {
  const std::size_t at = json.find("\"" + name + "\": ");
  return at == std::string::npos ? -1.0 : std::stod(json.substr(at + name.size() + 4));
}

/// Of the recording, which is written all along, bytes are missing; the rest waits in memory.
bool loses_bytes(std::string_view fault) {
  return fault == "disk:off" || fault == "disk:wrong" || fault == "disk:intermittent";
}

std::vector<std::string> real_time_run(const test::TempFolder& folder, const std::string& out,
                                       const std::vector<std::string>& more) {
  test::write_plain(folder / "b.toml", "name = \"b\"\n[map]\nresolution_m = 0.1\nthreads = 1\nmemory_mb = 64\n");
  std::vector<std::string> arguments{"run",     "--board", folder / "b.toml", "--world",  "house",        "--camera",
                                     "80x60@5", "--quiet", "--json",          "--record", folder / "log", "--out",
                                     out};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

/// What the robot has moved by its own account, which is exact here; below 0 if it does not answer.
double moved_by(const std::string& out) {
  const auto status = hal::ask_control_socket(out + "/control", "status");
  if (!status) return -1.0;
  return number_in(status.value(), "path_m") + 0.2 * number_in(status.value(), "turned_rad");
}

/// Waits for its first status, which is when the time of the fault has begun as well, up to a second or so.
bool waits_until_it_moves(const std::string& out) {
  for (int i = 0; i < 3000; ++i) {
    if (moved_by(out) > 0.05) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

}  // namespace

TEST_CASE("disk: the robot goes on, and what it mapped is saved when the disk is back", "[system][faults][disk]") {
  for (const test::FaultCell& cell : test::kFaultCells) {
    if (!std::string_view(cell.fault).starts_with("disk:")) continue;
    INFO(cell.fault);
    const test::TempFolder folder;
    const std::string out = folder / "out";
    // The fault lasts until the end of the drive, and some seconds into the saving.
    test::Program program(test::g3dmap_path(), real_time_run(folder, out,
                                                             {"--fail", std::string(cell.fault) + "@2+7", "--duration",
                                                              "7", "--patience", "60"}));
    REQUIRE(waits_until_it_moves(out));
    std::this_thread::sleep_for(std::chrono::seconds(2));
    const double before = moved_by(out);
    std::this_thread::sleep_for(std::chrono::seconds(2));
    CHECK(moved_by(out) - before > 0.1);
    const test::ProgramResult result = program.finish(std::chrono::seconds(120));
    INFO(result.err);
    CHECK(result.exit_code == (loses_bytes(cell.fault) ? 1 : 0));
    if (loses_bytes(cell.fault)) CHECK(contains(result.err, "kobuki.bin"));
    CHECK(contains(result.out, "\"stands\": true"));
    CHECK(test::report_is_balanced(out + "/report.json"));
    const auto map = mapper::read_any_map(out + "/map.g3d");
    REQUIRE(map.ok());
    CHECK(contains(result.out, mapper::map_hash(*map.value().map)));
    CHECK(contains(test::read_plain(out + "/report.json"), mapper::map_hash(*map.value().map)));
    const auto way = hal::read_trajectory(out + "/trajectory.tum");
    REQUIRE(way.ok());
    CHECK(way.value().size() == test::report_number(out + "/report.json", "integrated"));
    CHECK_FALSE(std::filesystem::exists(out + "/map.g3d.part"));
    CHECK_FALSE(std::filesystem::exists(out + "/control"));
  }
}

TEST_CASE("a disk that never comes back is said, with the report where there is no disk", "[system][faults][disk]") {
  for (const char* kind : {"off", "wrong", "garbage"}) {
    INFO(kind);
    const test::TempFolder folder;
    const std::string out = folder / "out";
    const test::ProgramResult result = test::run_g3dmap(real_time_run(
        folder, out, {"--fail", std::string("disk:") + kind + "@0.5", "--duration", "2", "--patience", "2"}));
    INFO(result.err);
    CHECK(result.exit_code == 1);
    CHECK(contains(result.err, out + "/map.g3d"));
    CHECK(contains(result.err, "trying again for 2 s"));
    CHECK(contains(result.out, "\"stands\": true"));
    CHECK(contains(result.out, "\"hash\": "));
    CHECK_FALSE(std::filesystem::exists(out + "/map.g3d"));
    CHECK_FALSE(std::filesystem::exists(out + "/report.json"));
  }
}

TEST_CASE("a robot whose disk hangs for ever still obeys Ctrl-C", "[system][faults][disk]") {
  const test::TempFolder folder;
  const std::string out = folder / "out";
  test::Program program(test::g3dmap_path(), real_time_run(folder, out, {"--fail", "disk:stuck@1"}));
  REQUIRE(waits_until_it_moves(out));
  program.send(SIGINT);
  std::this_thread::sleep_for(std::chrono::seconds(1));
  CHECK(program.is_running());  // it waits for the disk, and stands: the socket is gone, which is after the zeros
  for (int i = 0; i < 500 && std::filesystem::exists(out + "/control"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  CHECK_FALSE(std::filesystem::exists(out + "/control"));
  program.send(SIGINT);
  const test::ProgramResult result = program.finish(std::chrono::seconds(30));
  CHECK(result.exit_code == 130);
}
