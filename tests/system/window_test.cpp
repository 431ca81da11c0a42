// SPDX-License-Identifier: Apache-2.0
// `g3dmap sim --window`: a map that is larger than its memory, from the command line to the file.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::test;

namespace {

ProgramResult fly(const std::string& out, const std::string& resolution, const std::vector<std::string>& extra) {
  std::vector<std::string> arguments{"sim", "--world", "corridor", "--resolution", resolution, "--fps", "1", "--out"};
  arguments.insert(arguments.end(), {out, "--quiet"});
  arguments.insert(arguments.end(), extra.begin(), extra.end());
  return run_g3dmap(arguments);
}

}  // namespace

TEST_CASE("with a window, 16 MB hold the map that needs four times as much", "[system][window]") {
  const TempFolder folder;
  const std::string plenty = folder / "plenty";
  const std::string paged = folder / "paged";
  REQUIRE(fly(plenty, "0.02", {}).exit_code == 0);
  const ProgramResult result = fly(paged, "0.02", {"--memory", "16", "--window", "5"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(report_text(paged + "/report.json", "hash") == report_text(plenty + "/report.json", "hash"));
  CHECK(report_number(paged + "/report.json", "occupied") == report_number(plenty + "/report.json", "occupied"));
  CHECK(report_number(paged + "/report.json", "free") == report_number(plenty + "/report.json", "free"));
  CHECK(report_number(paged + "/report.json", "memory_bytes") < 17'000'000);
  CHECK(report_number(plenty + "/report.json", "memory_bytes") > 40'000'000);
  CHECK(report_number(paged + "/report.json", "refused_blocks") == 0);
  CHECK(report_number(paged + "/report.json", "regions_out") > 100);
  CHECK(read_plain(paged + "/map.g3d") == read_plain(plenty + "/map.g3d"));
  // What needs the whole map in memory was left out, and the user is told how to get it.
  CHECK_FALSE(std::filesystem::exists(paged + "/map.ot"));
  CHECK(read_plain(paged + "/report.json").find("g3dmap export") != std::string::npos);
}

TEST_CASE("a map that fits at the end is written in every format", "[system][window]") {
  const TempFolder folder;
  const std::string out = folder / "out";
  const ProgramResult result = fly(out, "0.1", {"--window", "5"});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(report_number(out + "/report.json", "regions_out") > 0);
  for (const char* name : {"map.g3d", "map.ot", "map.bt", "map.ply", "ground.pgm", "map.png"}) {
    CHECK(std::filesystem::file_size(out + "/" + name) > 0);
  }
}

TEST_CASE("a map that loops correct is the same with a window, and submaps that are far lie on disk",
          "[system][window][align]") {
  const TempFolder folder;
  const auto fly_on = [&](const std::string& name, const std::vector<std::string>& extra) {
    // A lap takes a minute: it comes back to where it began, and the whole map is put right.
    std::vector<std::string> arguments{"sim",   "--world", "corridor",   "--laps", "2",
                                       "--fps", "1.25",    "--duration", "69"};
    arguments.insert(arguments.end(), {"--seed", "5", "--drift", "1", "--odometry", "aligned", "--loops"});
    arguments.insert(arguments.end(), {"--resolution", "0.1", "--no-colour", "--no-noise", "--quiet", "--out"});
    arguments.push_back(folder / name);
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    const ProgramResult result = run_g3dmap(arguments);
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    return folder / name;
  };
  const std::string plenty = fly_on("plenty", {});
  const std::string paged = fly_on("paged", {"--window", "6"});
  const auto number = [&](const std::string& name) { return report_number(paged + "/report.json", name); };
  CHECK(number("corrections") > 0);
  CHECK(report_text(paged + "/report.json", "hash") == report_text(plenty + "/report.json", "hash"));
  CHECK(read_plain(paged + "/map.g3d") == read_plain(plenty + "/map.g3d"));
  CHECK(read_plain(paged + "/trajectory.tum") == read_plain(plenty + "/trajectory.tum"));
  CHECK(number("regions_out") > 0);
  CHECK(number("regions_in") > 0);
  CHECK(number("submaps_out") > 0);
  CHECK(number("submaps_in") > 0);
  CHECK(number("page_file_bytes") > 0);
  CHECK(number("refused_blocks") == 0);
  CHECK(number("failed_stores") + number("failed_loads") == 0);
  CHECK(read_plain(plenty + "/report.json").find("submaps_out") == std::string::npos);
  CHECK(std::filesystem::file_size(paged + "/map.bt") == std::filesystem::file_size(plenty + "/map.bt"));
}
