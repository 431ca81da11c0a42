// SPDX-License-Identifier: Apache-2.0
// `g3dmap sim --robots 2` as a user runs it: two explore a world together, and both end with the same map.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "mapper/files/any_map.hpp"
#include "mapper/map_hash.hpp"
#include "tests/support/report_reader.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::test;

namespace {

std::vector<std::string> together(const std::string& out, const std::vector<std::string>& extra = {}) {
  std::vector<std::string> arguments{"sim",      "--world",    "lab",     "--robots", "2",
                                     "--camera", "160x120@10", "--quiet", "--out",    out};
  arguments.insert(arguments.end(), extra.begin(), extra.end());
  return arguments;
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

std::string map_hash_of(const std::string& path) {
  const auto map = g3d::mapper::read_any_map(path);
  REQUIRE(map.ok());
  return g3d::mapper::map_hash(*map.value().map);
}

}  // namespace

TEST_CASE("two robots explore a world over a radio that loses a fifth, and hold the same map at the end",
          "[system][team]") {
  const TempFolder folder;
  const std::string out = folder / "out";
  const ProgramResult result = run_g3dmap(together(out, {"--loss", "0.2"}));
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  const std::string report = read_plain(out + "/report.json");
  CHECK(count_of(report, "\"all_hold_the_same\": true") == 1);
  CHECK(count_of(report, "\"home\": true") == 2);
  CHECK(report_number(out + "/report.json", "lost_datagrams") > 0);
  const std::string whole = map_hash_of(out + "/map.g3d");
  CHECK(count_of(report, "\"merged_hash\": \"" + whole + "\"") == 2);
  CHECK(read_plain(out + "/exploration.png").size() > 1000);
  // Neither has seen all of it.
  for (const char* robot : {"robot1", "robot2"}) {
    const std::string own = out + "/" + robot;
    CHECK(map_hash_of(own + "/map.g3d") != whole);
    CHECK(report_is_balanced(own + "/report.json"));
    CHECK(report_number(own + "/report.json", "stored_records") > 50);
    CHECK(report_number(own + "/report.json", "collisions") == 0);
  }
  // And once more the same.
  const ProgramResult again = run_g3dmap(together(folder / "again", {"--loss", "0.2"}));
  REQUIRE(again.exit_code == 0);
  CHECK(map_hash_of(folder / "again/map.g3d") == whole);
}

TEST_CASE("a robot dies while the radio is cut, and the other one finishes", "[system][team]") {
  const TempFolder folder;
  const std::string out = folder / "out";
  const ProgramResult result = run_g3dmap(together(out, {"--partition", "5-20:1|2", "--kill", "1@25"}));
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(report_number(out + "/robot1/report.json", "died_s") == 25);
  CHECK(count_of(read_plain(out + "/robot2/report.json"), "\"home\": true") == 1);
  // It was led before, and has led itself since.
  CHECK(report_number(out + "/robot2/report.json", "leader") == 2);
  CHECK(report_number(out + "/robot2/report.json", "begun_terms") >= 1);
  CHECK(report_number(out + "/robot2/report.json", "changed_leaders") >= 3);
  CHECK(report_number(out + "/robot2/report.json", "robot_contacts") == 0);
}

TEST_CASE("what does not go with several robots is said so", "[system][team]") {
  const TempFolder folder;
  const auto refused = [&](const std::vector<std::string>& extra, const std::string& why) {
    const ProgramResult result = run_g3dmap(together(folder / "out", extra));
    INFO(result.err);
    CHECK(result.exit_code == 2);
    CHECK(result.err.find(why) != std::string::npos);
  };
  refused({"--rate", "1"}, "--rate");
  refused({"--at", "3:pause"}, "--at");
  refused({"--loss", "1.5"}, "--loss");
  refused({"--kill", "3@10"}, "--kill '3@10'");
  refused({"--partition", "9-3:1|2"}, "--partition '9-3:1|2'");
  const ProgramResult alone =
      run_g3dmap({"sim", "--world", "lab", "--robots", "1", "--loss", "0.1", "--quiet", "--out", folder / "out"});
  CHECK(alone.exit_code == 2);
  CHECK(alone.err.find("--loss") != std::string::npos);
  const ProgramResult dead =
      run_g3dmap({"sim", "--world", "lab", "--robots", "1", "--kill", "1@3", "--quiet", "--out", folder / "out"});
  CHECK(dead.exit_code == 2);
  CHECK(dead.err.find("--kill") != std::string::npos);
}
