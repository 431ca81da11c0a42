// SPDX-License-Identifier: Apache-2.0
#include "net/team_frame.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "hal/geometry.hpp"

using namespace g3d;

namespace {

constexpr double kQuarter_rad = 1.5707963267948966;

bool is_near(const hal::PlanarPose& a, const hal::PlanarPose& b) {
  return std::abs(a.x_m - b.x_m) < 1e-6 && std::abs(a.y_m - b.y_m) < 1e-6 &&
         std::abs(std::remainder(a.heading_rad - b.heading_rad, 4.0 * kQuarter_rad)) < 1e-6;
}

/// A map that begins at (2, 1) of the world, a quarter turned to the left, and 0.3 m higher.
hal::Pose turned_map() { return hal::from_xyz_rpy(2.0, 1.0, 0.3, 0.0, 0.0, kQuarter_rad); }

}  // namespace

TEST_CASE("what a robot says of its map's frame is said of the world's", "[net][team]") {
  nav::TeamWord word;
  word.T_world_base = {1.0, 0.0, 0.0};
  word.has_goal = true;
  word.goal = {0.0, 2.0, kQuarter_rad};
  word.way[0] = {1.0F, 0.0F, 0.0F};
  word.way[1] = {0.0F, 2.0F, 5.0F};
  word.way_count = 2;
  word.offers[0] = {{3.0, 0.0, 0.5}, 4.0F, 50.0F};
  word.offer_count = 1;
  const nav::TeamWord said = net::in_world(word, turned_map());
  CHECK(is_near(said.T_world_base, {2.0, 2.0, kQuarter_rad}));
  CHECK(is_near(said.goal, {0.0, 1.0, 2.0 * kQuarter_rad}));
  CHECK(said.way[1].x_m == Approx(0.0).margin(1e-6));
  CHECK(said.way[1].y_m == Approx(1.0));
  CHECK(said.way[1].after_s == 5.0F);
  CHECK(is_near(said.offers[0].goal, {2.0, 4.0, kQuarter_rad + 0.5}));
  CHECK(said.offers[0].travel_s == 4.0F);
}

TEST_CASE("what is known of a team is where the robot's own map has it", "[net][team]") {
  nav::TeamSight sight;
  sight.self = 7;
  sight.count = 1;
  sight.mates[0].robot = 3;
  sight.mates[0].T_world_base = {2.0, 2.0, kQuarter_rad};
  sight.mates[0].goal = {0.0, 1.0, 2.0 * kQuarter_rad};
  sight.mates[0].way[0] = {2.0F, 2.0F, 0.0F};
  sight.mates[0].way_count = 1;
  sight.assigned = hal::PlanarPose{2.0, 4.0, kQuarter_rad};
  const nav::TeamSight seen = net::in_map(sight, turned_map());
  CHECK(seen.self == 7);
  CHECK(is_near(seen.mates[0].T_world_base, {1.0, 0.0, 0.0}));
  CHECK(is_near(seen.mates[0].goal, {0.0, 2.0, kQuarter_rad}));
  CHECK(seen.mates[0].way[0].x_m == Approx(1.0));
  CHECK(seen.mates[0].way[0].y_m == Approx(0.0).margin(1e-6));
  REQUIRE(seen.assigned);
  CHECK(is_near(*seen.assigned, {3.0, 0.0, 0.0}));
}

TEST_CASE("where maps stand in the world's frame words are passed on to the bit", "[net][team]") {
  nav::TeamWord word;
  word.T_world_base = {0.1, 0.7, 3.0};
  word.way[0] = {0.1F, 0.7F, 0.0F};
  word.way_count = 1;
  const nav::TeamWord said = net::in_world(word, hal::Pose{});
  CHECK(said.T_world_base == word.T_world_base);
  CHECK(said.way[0].x_m == word.way[0].x_m);
}
