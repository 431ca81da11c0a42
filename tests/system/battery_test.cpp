// SPDX-License-Identifier: Apache-2.0
// A battery that will not do for the whole building: the robot is home again before it is empty, and says what it left
// for want of energy.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::test;

TEST_CASE("a robot is home before its battery is empty", "[system][battery]") {
  for (const char* world : {"warehouse", "loops"}) {
    double last_m = 0.0;
    for (const char* minutes : {"1", "1.5", "2.5"}) {
      INFO(world << ", " << minutes << " minutes");
      const TempFolder folder;
      // Twice the battery's life: one that does not get home is found empty, not cut off.
      const ProgramResult result =
          run_g3dmap({"sim", "--world", world, "--robots", "1", "--camera", "160x120@10", "--battery", minutes,
                      "--duration", "300", "--quiet", "--out", folder / "out"});
      INFO(result.err);
      REQUIRE(result.exit_code == 0);
      const std::string report = folder / "out/report.json";
      CHECK(report_text(report, "state") == "home");
      CHECK(report_number(report, "battery_empty") == 0);
      CHECK(report_number(report, "energy") > 0);
      CHECK(report_number(report, "open") == 0);
      const double way_m = static_cast<double>(report_number(report, "path_m"));
      CHECK(way_m > last_m + 4.0);  // what the battery gives is used
      last_m = way_m;
    }
  }
}

TEST_CASE("a battery that does for the whole building changes nothing", "[system][battery]") {
  std::string hash;
  for (const char* minutes : {"", "600"}) {
    const TempFolder folder;
    std::vector<std::string> arguments{"sim",      "--world",    "lab",     "--robots", "1",
                                       "--camera", "160x120@10", "--quiet", "--out",    folder / "out"};
    if (*minutes != '\0') arguments.insert(arguments.end(), {"--battery", minutes});
    REQUIRE(run_g3dmap(arguments).exit_code == 0);
    CHECK(report_number(folder / "out/report.json", "energy") == 0);
    if (!hash.empty()) CHECK(report_text(folder / "out/report.json", "hash") == hash);
    hash = report_text(folder / "out/report.json", "hash");
  }
}
