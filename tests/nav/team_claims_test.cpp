// SPDX-License-Identifier: Apache-2.0
#include "nav/team_claims.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <optional>

#include "nav/explorer.hpp"

using namespace g3d;
using nav::CellGrid;
using nav::CellState;

namespace {

constexpr hal::TimeNs kChosen_ns = 3'000'000'000;

/// A square known room of 6 m with an open side in the west and one in the east.
struct Hall {
  CellGrid<CellState> ground{0.05, -8.0, -8.0, 320, 320, CellState::unknown};
  CellGrid<std::uint8_t> cost{0.05, -8.0, -8.0, 320, 320, nav::kUnknownCost};
  Hall() {
    for (int y = 100; y < 220; ++y) {
      for (int x = 100; x < 220; ++x) {
        const bool is_wall = y < 104 || y >= 216;
        ground.at({x, y}) = is_wall ? CellState::occupied : CellState::free;
        cost.at({x, y}) = y < 109 || y >= 211 ? nav::kInscribedCost : nav::kFreeCost;
      }
    }
  }
  [[nodiscard]] nav::Decision decide(nav::Explorer& explorer, const hal::PlanarPose& robot, hal::TimeNs now) const {
    for (int i = 0; i < 2000; ++i) {
      if (const auto made = explorer.decide(ground, cost, {}, robot, now)) return *made;
    }
    FAIL("it never decides");
    return {};
  }
};

nav::ExplorerConfig no_look_around() {
  nav::ExplorerConfig config;
  config.look_around_first = false;
  return config;
}

nav::TeamSight claim_at(const hal::PlanarPose& goal, std::uint64_t robot, std::uint64_t self) {
  nav::TeamSight sight;
  sight.self = self;
  sight.count = 1;
  sight.mates[0].robot = robot;
  sight.mates[0].told_ns = kChosen_ns;
  sight.mates[0].has_goal = true;
  sight.mates[0].goal = goal;
  return sight;
}

}  // namespace

TEST_CASE("a chooser leaves a claimed place, and what is seen from there, to whoever claims it", "[nav][team]") {
  const Hall hall;
  const hal::PlanarPose robot{0.3, 0.0, 0.0};
  nav::Explorer alone(no_look_around());
  alone.prepare(hall.ground, hall.cost);
  const nav::Decision first = hall.decide(alone, robot, kChosen_ns);
  REQUIRE(first.kind == nav::DecisionKind::goal);

  nav::Explorer other(no_look_around());
  other.prepare(hall.ground, hall.cost);
  other.set_team(claim_at(first.goal, 1, 2), kChosen_ns);
  const nav::Decision second = hall.decide(other, robot, kChosen_ns);
  REQUIRE(second.kind == nav::DecisionKind::goal);
  CHECK(std::hypot(second.goal.x_m - first.goal.x_m, second.goal.y_m - first.goal.y_m) >= nav::TeamClaims::kApart_m);

  // A claim that is old, or nobody's, changes nothing.
  nav::Explorer later(no_look_around());
  later.prepare(hall.ground, hall.cost);
  const hal::TimeNs after_ns = kChosen_ns + nav::TeamClaims::kClaimHolds_ns;
  later.set_team(claim_at(first.goal, 1, 2), after_ns);
  CHECK(hall.decide(later, robot, after_ns).goal == first.goal);
}

TEST_CASE("of two that chose one place at once the lower id keeps it", "[nav][team]") {
  const Hall hall;
  const hal::PlanarPose robot{0.3, 0.0, 0.0};
  for (const bool goes_first : {true, false}) {
    nav::Explorer explorer(no_look_around());
    explorer.prepare(hall.ground, hall.cost);
    const nav::Decision first = hall.decide(explorer, robot, kChosen_ns);
    explorer.set_team(claim_at(first.goal, goes_first ? 7 : 1, 2), kChosen_ns);
    const nav::Decision then = hall.decide(explorer, robot, kChosen_ns + 2'000'000'000);
    const double apart_m = std::hypot(then.goal.x_m - first.goal.x_m, then.goal.y_m - first.goal.y_m);
    if (goes_first) {
      CHECK(apart_m == 0.0);
    } else {
      CHECK(apart_m >= nav::TeamClaims::kApart_m);
    }
  }
}

TEST_CASE("where all that is left is claimed, a robot helps rather than goes home", "[nav][team]") {
  const Hall hall;
  const hal::PlanarPose robot{0.3, 0.0, 0.0};
  nav::Explorer explorer(no_look_around());
  explorer.prepare(hall.ground, hall.cost);
  nav::TeamSight sight = claim_at({-2.0, 0.0, 3.1}, 1, 3);
  sight.mates[1] = sight.mates[0];
  sight.mates[1].robot = 2;
  sight.mates[1].goal = {2.0, 0.0, 0.0};
  sight.count = 2;
  explorer.set_team(sight, kChosen_ns);
  const nav::Decision decision = hall.decide(explorer, robot, kChosen_ns);
  REQUIRE(decision.kind == nav::DecisionKind::goal);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(std::hypot(decision.goal.x_m - sight.mates[i].goal.x_m, decision.goal.y_m - sight.mates[i].goal.y_m) >=
          nav::TeamClaims::kApart_m);
  }
}

TEST_CASE("what is offered are distinct places, the own goal first; the leader's choice among them is taken",
          "[nav][team]") {
  const Hall hall;
  const hal::PlanarPose robot{0.3, 0.0, 0.0};
  nav::Explorer explorer(no_look_around());
  explorer.prepare(hall.ground, hall.cost);
  const nav::Decision first = hall.decide(explorer, robot, kChosen_ns);
  std::array<nav::Offer, nav::kMostOffers> offers;
  const std::size_t count = explorer.offers(offers);
  REQUIRE(count >= 2);
  CHECK(offers[0].goal == first.goal);
  for (std::size_t i = 0; i < count; ++i) {
    CHECK(offers[i].gain_cells > 0.0F);
    CHECK(offers[i].travel_s >= 0.0F);
    for (std::size_t j = 0; j < i; ++j) {
      CHECK(std::hypot(offers[i].goal.x_m - offers[j].goal.x_m, offers[i].goal.y_m - offers[j].goal.y_m) >=
            nav::TourOffers::kDistinct_m);
    }
  }
  nav::TeamSight sight;
  sight.self = 2;
  sight.count = 1;
  sight.mates[0].robot = 1;
  sight.mates[0].told_ns = kChosen_ns;
  sight.assigned = offers[count - 1].goal;
  explorer.set_team(sight, kChosen_ns);
  const nav::Decision then = hall.decide(explorer, robot, kChosen_ns + 2'000'000'000);
  CHECK(std::hypot(then.goal.x_m - sight.assigned->x_m, then.goal.y_m - sight.assigned->y_m) <
        nav::TeamClaims::kAssigned_m);
}
