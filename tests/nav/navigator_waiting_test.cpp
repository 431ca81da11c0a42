// SPDX-License-Identifier: Apache-2.0
// Navigators that get by one another; tests/nav/navigator_test.cpp has those of one alone.
#include "nav/navigator.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/small_team.hpp"

using namespace g3d;
using tests::Box;
using tests::SmallTeam;

namespace {

constexpr double kEast_rad = 0.0, kWest_rad = 3.1, kNorth_rad = 1.57, kSouth_rad = -1.57;

/// Two rooms 3 m wide with a corridor 4 m long between them.
std::vector<Box> corridor(double wide_m) {
  std::vector<Box> walls = tests::walls_around({0, 0, 10, 3});
  walls.push_back({3, 0, 7, 1.5 - 0.5 * wide_m});
  walls.push_back({3, 1.5 + 0.5 * wide_m, 7, 3});
  return walls;
}
constexpr Box kCorridorExtent{-0.2, -0.2, 10.2, 3.2};

}  // namespace

TEST_CASE("robots whose ways cross in the open do not touch", "[nav][navigator][team][slow]") {
  SmallTeam team(tests::walls_around({0, 0, 6, 6}), {-0.2, -0.2, 6.2, 6.2},
                 {{{0.6, 3, kEast_rad}, {{5.4, 3, kEast_rad}, {0.6, 3, kWest_rad}}},
                  {{3, 0.6, kNorth_rad}, {{3, 5.4, kNorth_rad}, {3, 0.6, kSouth_rad}}},
                  {{5.4, 3.4, kWest_rad}, {{0.6, 3.1, kWest_rad}, {5.4, 3.1, kEast_rad}}}});
  CHECK(team.run_until_each_reached(3, 150.0));
  CHECK(team.least_gap_m() > 0.02);
  CHECK(team.wall_contacts() == 0);
  INFO("took " << team.time_s() << " s, gap " << team.least_gap_m());
  CHECK(team.time_s() < 150.0);
}

TEST_CASE("two robots meet in a corridor where they cannot pass: one makes room", "[nav][navigator][team]") {
  const double wide_m = GENERATE(0.7, 1.1);
  SmallTeam team(corridor(wide_m), kCorridorExtent,
                 {{{1.0, 1.5, kEast_rad}, {{9.0, 1.5, kEast_rad}, {1.0, 1.5, kWest_rad}}},
                  {{9.0, 1.5, kWest_rad}, {{1.0, 1.2, kWest_rad}, {9.0, 1.8, kEast_rad}}}});
  CHECK(team.run_until_each_reached(2, 240.0));
  INFO("took " << team.time_s() << " s, gap " << team.least_gap_m() << " in " << wide_m << " m; failed "
               << team.errands(0).failed() << " and " << team.errands(1).failed());
  CHECK(team.least_gap_m() > 0.02);
  CHECK(team.wall_contacts() == 0);
  CHECK(team.time_s() < 240.0);
}

TEST_CASE("face to face within a narrow corridor: the one that goes after backs out", "[nav][navigator][team]") {
  SmallTeam team(corridor(0.7), kCorridorExtent,
                 {{{4.2, 1.5, kEast_rad}, {{9.0, 1.5, kEast_rad}, {1.0, 1.5, kWest_rad}}},
                  {{5.4, 1.5, kWest_rad}, {{1.0, 1.5, kWest_rad}, {9.0, 1.5, kEast_rad}}}});
  CHECK(team.run_until_each_reached(1, 120.0));
  INFO("took " << team.time_s() << " s, gap " << team.least_gap_m());
  CHECK(team.least_gap_m() > 0.02);
  CHECK(team.errands(0).failed() == 0);
}

TEST_CASE("three robots go to and fro through one door though words are late and lost", "[nav][navigator][team]") {
  std::vector<Box> walls = tests::walls_around({0, 0, 8, 4});
  walls.push_back({3.95, 0, 4.05, 1.6});
  walls.push_back({3.95, 2.4, 4.05, 4});
  tests::SmallTeamOptions options;
  options.word_period_s = 0.2;
  options.word_delay_s = 0.2;
  options.loss = 0.3;
  SmallTeam team(walls, {-0.2, -0.2, 8.2, 4.2},
                 {{{1, 1, kEast_rad}, {{7, 1, kEast_rad}, {1, 1, kWest_rad}}},
                  {{7, 3, kWest_rad}, {{1, 3, kWest_rad}, {7, 3, kEast_rad}}},
                  {{7, 1.8, kWest_rad}, {{1, 2, kWest_rad}, {7, 2, kEast_rad}}}},
                 options);
  CHECK(team.run_until_each_reached(3, 300.0));
  INFO("took " << team.time_s() << " s, gap " << team.least_gap_m());
  CHECK(team.least_gap_m() > 0.01);
  CHECK(team.wall_contacts() == 0);
}

TEST_CASE("a robot that dies on the way is driven around for as long as it lies there", "[nav][navigator][team]") {
  SmallTeam team(tests::walls_around({0, 0, 6, 3}), {-0.2, -0.2, 6.2, 3.2},
                 {{{3.0, 1.5, kEast_rad}, {{5.4, 1.5, kEast_rad}, {3.0, 1.5, kWest_rad}}},
                  {{0.6, 1.5, kEast_rad}, {{5.4, 1.6, kEast_rad}, {0.6, 1.4, kWest_rad}}}});
  for (int i = 0; i < 50; ++i) team.step();
  team.kill(0);
  CHECK(team.run_until_each_reached(3, 120.0));
  INFO("took " << team.time_s() << " s, gap " << team.least_gap_m());
  CHECK(team.least_gap_m() > 0.0);
  CHECK(team.errands(1).failed() == 0);
}

TEST_CASE("what a navigator tells of itself: its way, its claim, and that it stands", "[nav][navigator][team]") {
  SmallTeam team(tests::walls_around({0, 0, 6, 3}), {-0.2, -0.2, 6.2, 3.2},
                 {{{0.6, 1.5, kEast_rad}, {{5.4, 1.5, kEast_rad}, {0.6, 1.5, kWest_rad}}}});
  while (team.time_s() < 4.0) team.step();
  const nav::TeamWord word = team.navigator(0).team_word(0);
  CHECK(word.is_moving);
  REQUIRE(word.way_count >= 2);
  const nav::WayPoint& end = word.way[word.way_count - 1];
  CHECK(static_cast<double>(end.x_m) == Approx(5.4).margin(0.1));
  CHECK(static_cast<double>(end.after_s) > 5.0);
  // The first errand is told as a claim once the mission explores.
  CHECK(word.goal.x_m == Approx(5.4));
  CHECK(word.has_goal);
  team.navigator(0).command(nav::MissionEvent::pause);
  for (int i = 0; i < 100; ++i) team.step();
  const nav::TeamWord paused = team.navigator(0).team_word(0);
  CHECK_FALSE(paused.is_moving);
  CHECK(paused.way_count == 1);
  CHECK_FALSE(paused.has_goal);
}
