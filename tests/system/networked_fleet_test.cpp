// SPDX-License-Identifier: Apache-2.0
// Whole programs in network namespaces of their own, as on machines at one access point: they find each other by
// multicast, with the options that a robot has by itself, and a radio goes down meanwhile.
#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "hal/linux/control_socket.hpp"
#include "tests/support/access_point.hpp"
#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::test;

namespace {

struct NetworkedPrograms {
  NetworkedPrograms() {
    REQUIRE(run_g3dmap({"key", "--out", folder / "fleet.key"}).exit_code == 0);
    const std::string map = "[map]\nresolution_m = 0.1\nthreads = 1\nmemory_mb = 64\n";
    write_plain(folder / "robot.toml", "name = \"robot\"\n" + map);
    write_plain(folder / "station.toml",
                "name = \"station\"\n[base]\nline = \"none\"\n[camera]\nsource = \"none\"\n" + map);
  }
  [[nodiscard]] std::vector<std::string> run(const std::string& board, int number) const {
    return {"run",
            "--board",
            folder / (board + ".toml"),
            "--key",
            folder / "fleet.key",
            "--robot",
            "a" + std::to_string(number),
            "--quiet",
            "--out",
            out(number)};
  }
  [[nodiscard]] std::vector<std::string> robot(int number) const {
    std::vector<std::string> all = run("robot", number);
    all.insert(all.end(),
               {"--world", "two_rooms", "--camera", "80x60@5", "--start", std::to_string(number), "--duration", "5"});
    return all;
  }
  [[nodiscard]] std::string out(int number) const { return folder / ("out" + std::to_string(number)); }
  [[nodiscard]] std::string report(int number) const { return out(number) + "/report.json"; }
  [[nodiscard]] bool says(int number, const std::string& part) const {
    for (int i = 0; i < 1000; ++i) {
      const auto status = hal::ask_control_socket(out(number) + "/control", "peers");
      if (status.ok() && status.value().find(part) != std::string::npos) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }
  TempFolder folder;
};

}  // namespace

TEST_CASE("robots and a base station on machines of their own end with one map, though a radio goes down meanwhile",
          "[system][fleet][netns][waits]") {
  (void)in_own_network([] {
    const AccessPoint place(3);
    if (!place.build()) return;
    const NetworkedPrograms fleet;
    place.enter(0);
    Program station(g3dmap_path(), fleet.run("station", 0));
    place.enter(1);
    Program one(g3dmap_path(), fleet.robot(1));
    place.enter(2);
    Program two(g3dmap_path(), fleet.robot(2));
    CHECK(fleet.says(0, "\"id\": \"00000000000000a1\""));
    CHECK(fleet.says(0, "\"id\": \"00000000000000a2\""));
    CHECK(fleet.says(0, "10.77.0.3:7177"));
    place.set_radio_up(2, false);
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    place.set_radio_up(2, true);
    for (Program* robot : {&one, &two}) {
      const ProgramResult result = robot->finish(std::chrono::seconds(60));
      INFO(result.err);
      CHECK(result.exit_code == 0);
    }
    REQUIRE(hal::ask_control_socket(fleet.out(0) + "/control", "stop"));
    const ProgramResult result = station.finish(std::chrono::seconds(60));
    INFO(result.err);
    CHECK(result.exit_code == 0);
    const std::string hash = report_text(fleet.report(0), "merged_hash");
    CHECK(report_number(fleet.report(0), "free") > 0);
    CHECK(report_text(fleet.report(1), "merged_hash") == hash);
    CHECK(report_text(fleet.report(2), "merged_hash") == hash);
    CHECK(report_text(fleet.report(1), "hash") != hash);
  });
}
