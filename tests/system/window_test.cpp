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
