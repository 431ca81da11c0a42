// SPDX-License-Identifier: Apache-2.0
#include "nav/refuge.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/support/kinematic_robot.hpp"

using namespace g3d;
using tests::Box;

namespace {

constexpr hal::TimeNs kSought_ns = 20'000'000'000;

nav::TeamSight first_comes(const std::vector<nav::WayPoint>& way) {
  nav::TeamSight sight;
  sight.self = 2;
  nav::Teammate& mate = sight.mates[0];
  mate.robot = 1;
  mate.told_ns = kSought_ns;
  mate.is_moving = true;
  for (const nav::WayPoint& point : way) mate.way[mate.way_count++] = point;
  mate.T_world_base = {static_cast<double>(way[0].x_m), static_cast<double>(way[0].y_m), 0.0};
  sight.count = 1;
  return sight;
}

/// A corridor 0.8 m wide along y = 0 with a niche on its north side about x = `niche_x_m`.
nav::CellGrid<std::uint8_t> corridor_with_niche(double niche_x_m) {
  std::vector<Box> walls{{-4.5, -1.0, 4.5, -0.4}, {-4.5, 0.4, niche_x_m - 0.5, 1.6}, {niche_x_m + 0.5, 0.4, 4.5, 1.6}};
  walls.push_back({-4.5, -0.4, -4.3, 0.4});
  walls.push_back({4.3, -0.4, 4.5, 0.4});
  walls.push_back({-4.5, 1.5, 4.5, 1.6});
  return tests::plain_costs(tests::known_floor(walls, {-4.5, -1.0, 4.5, 1.6}));
}

}  // namespace

TEST_CASE("a robot that is in the way finds the niche behind it", "[nav][team]") {
  const auto cost = corridor_with_niche(-2.0);
  nav::Refuge refuge(cost.resolution_m);
  const auto sight = first_comes({{3.0F, 0.0F, 0.0F}, {-4.0F, 0.0F, 18.0F}});
  const auto room = refuge.find(cost, sight, kSought_ns, {0.0, 0.0, 0.0}, {});
  REQUIRE(room);
  CHECK(std::fabs(room->x_m + 2.0) < 0.5);
  CHECK(room->y_m > 0.46);
  CHECK(cost.at(cost.cell_of(room->x_m, room->y_m)) < nav::kInscribedCost);
}

TEST_CASE("it does not look for room behind the one who comes", "[nav][team]") {
  const auto cost = corridor_with_niche(2.0);
  nav::Refuge refuge(cost.resolution_m);
  const auto sight = first_comes({{1.0F, 0.0F, 0.0F}, {-4.0F, 0.0F, 13.0F}});
  CHECK_FALSE(refuge.find(cost, sight, kSought_ns, {-0.5, 0.0, 0.0}, {}));
}

TEST_CASE("it gets out of the way before the other is there, and asks for nothing where none comes", "[nav][team]") {
  const auto cost = corridor_with_niche(1.0);
  nav::Refuge refuge(cost.resolution_m);
  // He is 3 m beyond the niche: time enough.
  const auto room =
      refuge.find(cost, first_comes({{4.0F, 0.0F, 0.0F}, {-4.0F, 0.0F, 20.0F}}), kSought_ns, {0.0, 0.0, 0.0}, {});
  REQUIRE(room);
  CHECK(std::fabs(room->x_m - 1.0) < 0.5);
  nav::TeamSight nobody = first_comes({{4.0F, 0.0F, 0.0F}, {-4.0F, 0.0F, 20.0F}});
  nobody.self = 1;
  nobody.mates[0].robot = 2;
  const auto here = refuge.find(cost, nobody, kSought_ns, {0.0, 0.0, 0.0}, {});
  REQUIRE(here);
  CHECK(std::hypot(here->x_m, here->y_m) < 0.06);
}
