// SPDX-License-Identifier: Apache-2.0
#include "net/team_report.hpp"

#include <catch2/catch.hpp>

#include "tests/support/team_fleet.hpp"

using namespace g3d;

TEST_CASE("a report says who led a robot, and what it said", "[net][team]") {
  tests::TeamFleetOptions options;
  options.fleet.robots = 2;
  tests::TeamFleet team(options);
  team.run(6'000'000'000);
  mapper::JsonWriter json;
  json.begin_object();
  net::write_in_team(json, team.talk(1));
  json.end_object();
  const std::string text = json.take();
  CHECK(text.find("\"leader\": 1") != std::string::npos);
  CHECK(text.find("\"cluster\": 2") != std::string::npos);
  CHECK(text.find("\"changed_leaders\": 1") != std::string::npos);
  CHECK(text.find("\"words\": 0") == std::string::npos);
  CHECK(text.find("\"words_unread\": 0") != std::string::npos);
}
