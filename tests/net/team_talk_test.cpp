// SPDX-License-Identifier: Apache-2.0
#include "net/team_talk.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/team_fleet.hpp"

using namespace g3d;
using tests::TeamFleet;
using tests::TeamFleetOptions;

namespace {

constexpr hal::TimeNs kTalkSecond_ns = 1'000'000'000;

TeamFleetOptions team_of(std::uint32_t robots, double loss, std::uint64_t seed) {
  TeamFleetOptions options;
  options.fleet.robots = robots;
  options.fleet.radio.loss = loss;
  options.fleet.radio.seed = seed;
  return options;
}

/// No leader orders two to one place.
void check_orders(const TeamFleet& team) {
  for (std::uint32_t i = 0; i < team.size(); ++i) {
    if (!team.is_alive(i)) continue;
    const net::OrdersWord& orders = team.talk(i).own_orders();
    for (std::size_t a = 0; a < orders.count; ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        if (net::apart_m(orders.orders[a].goal, orders.orders[b].goal) < 1.49) FAIL("two are sent to one place");
      }
    }
  }
}

/// How long the claim of a robot that dies is respected by anybody, from its death on.
hal::TimeNs claim_outlives_ns(double loss, std::uint64_t seed) {
  TeamFleetOptions options = team_of(4, loss, seed);
  options.places = 40;
  TeamFleet team(options);
  hal::SeededRandom random(seed);
  team.run(5 * kTalkSecond_ns + static_cast<hal::TimeNs>(random.bits() % 5000) * 1'000'000);
  const auto dead = static_cast<std::uint32_t>(random.bits() % 4);
  const hal::TimeNs died_ns = team.fleet().now_ns();
  team.kill(dead);
  hal::TimeNs last_ns = died_ns;
  for (int i = 0; i < 500; ++i) {
    team.step();
    for (std::uint32_t other = 0; other < 4; ++other) {
      if (team.is_alive(other) && team.respects(other, dead + 1)) last_ns = team.fleet().now_ns();
    }
  }
  return last_ns - died_ns;
}

/// Robots die, come back and are cut off while they work; then they are left in peace: one leader in every group, no
/// two sent to one place at any time, and all places are seen in the end.
void check_team(std::uint64_t seed) {
  INFO("schedule " << seed);
  hal::SeededRandom random(seed);
  const auto robots = 2 + static_cast<std::uint32_t>(random.bits() % 3);
  TeamFleet team(team_of(robots, random.uniform() * 0.4, seed));
  for (int e = static_cast<int>(random.bits() % 6); e > 0; --e) {
    const auto robot = static_cast<std::uint32_t>(random.bits() % robots);
    if (random.bits() % 3 == 0) {
      if (team.is_alive(robot)) {
        team.kill(robot);
      } else {
        team.start(robot);
      }
    } else {
      team.fleet().set_group(robot, static_cast<int>(random.bits() % 2));
    }
    for (auto steps = random.bits() % 200; steps > 0; --steps) team.step();
    check_orders(team);
  }
  if (!team.is_alive(0)) team.start(0);
  net::RadioModel quiet;
  quiet.loss = 0.1;
  quiet.seed = seed;
  team.fleet().radio().set_model(quiet);
  team.run(10 * kTalkSecond_ns);
  CHECK(team.is_settled());
  check_orders(team);
}

double p99_s(std::vector<hal::TimeNs> times) {
  std::sort(times.begin(), times.end());
  return static_cast<double>(times[times.size() * 99 / 100]) * 1e-9;
}

}  // namespace

TEST_CASE("a team shares out the places and sees them all", "[net][team]") {
  TeamFleet team(team_of(3, 0.1, 5));
  for (int i = 0; i < 120 && team.open_places() > 0; ++i) {
    team.run(kTalkSecond_ns);
    check_orders(team);
  }
  CHECK(team.open_places() == 0);
  CHECK(team.shared_places() == 0);
  CHECK(team.is_settled());
  CHECK(team.talk(0).counts().assignments > 10);
  for (const std::uint64_t faults : team.talk(1).book().counts().faults) CHECK(faults == 0);
}

TEST_CASE("robots see each other where they are, and where they will be", "[net][team]") {
  TeamFleet team(team_of(2, 0.0, 9));
  team.run(8 * kTalkSecond_ns);
  const nav::TeamSight& sight = team.talk(0).sight();
  CHECK(sight.self == 1);
  REQUIRE(sight.count == 1);
  const nav::Teammate& mate = sight.mates[0];
  const nav::TeamWord& word = team.word(1);
  CHECK(mate.robot == 2);
  CHECK(mate.radius_m == Approx(0.18F));
  REQUIRE(mate.is_moving);
  REQUIRE(mate.way_count == 2);
  // It was there some tenths of a second ago, and has driven its way since.
  const double ago_s = static_cast<double>(team.fleet().now_ns() - mate.told_ns) * 1e-9;
  CHECK(ago_s >= 0.0);
  CHECK(ago_s < 0.8);
  CHECK(net::apart_m(mate.T_world_base, word.T_world_base) == Approx(0.4 * ago_s).margin(0.05));
  CHECK(net::apart_m(mate.goal, word.goal) < 0.02);
}

TEST_CASE("a leader sends elsewhere who would go to another one's place, and nobody else", "[net][team]") {
  TeamFleetOptions options = team_of(4, 0.0, 11);
  options.places = 100;
  options.extent_m = 10.0;  // they are in each other's way,
  options.talk.assignment.crowded_m = 5.0;
  options.talk.assignment.crowded_s = 20.0;  // and that counts
  options.talk.assignment.rank_s = 2.0;
  TeamFleet team(options);
  team.run(10 * kTalkSecond_ns);
  REQUIRE(team.is_settled());
  int ordered = 0;
  for (int i = 0; i < 100; ++i) {
    team.run(kTalkSecond_ns / 5);
    for (std::uint32_t r = 0; r < 4; ++r) ordered += team.talk(r).sight().assigned.has_value() ? 1 : 0;
  }
  // Most go where they would go anyway.
  CHECK(ordered > 10);
  CHECK(ordered < 240);
  CHECK(team.talk(0).counts().orders > 10);
  CHECK(team.shared_places() == 0);
}

TEST_CASE("orders of one who does not lead any more are void", "[net][team]") {
  TeamFleetOptions options = team_of(3, 0.0, 12);
  options.places = 100;
  options.extent_m = 10.0;  // they are in each other's way,
  options.talk.assignment.crowded_m = 5.0;
  options.talk.assignment.crowded_s = 20.0;  // and that counts
  options.talk.assignment.rank_s = 2.0;
  TeamFleet team(options);
  team.run(10 * kTalkSecond_ns);
  REQUIRE(team.talk(2).cluster().office().leader == 1);
  team.kill(0);
  team.run(5 * kTalkSecond_ns + kTalkSecond_ns / 2);
  REQUIRE(team.is_settled());
  CHECK(team.talk(2).cluster().office() == net::Office{2, 2});
  // The old leader's last orders are still in everybody's store.
  REQUIRE(team.talk(2).book().find(1) != nullptr);
  CHECK(team.talk(2).book().find(1)->orders.term == 1);
  int assigned = 0, by_new_leader = 0;
  for (int i = 0; i < 100; ++i) {
    team.run(kTalkSecond_ns / 10);
    const auto goal = team.talk(2).sight().assigned;
    if (!goal) continue;
    ++assigned;
    const net::OrdersWord& orders = team.talk(2).book().find(2)->orders;
    by_new_leader +=
        std::any_of(orders.orders.begin(), orders.orders.begin() + static_cast<std::ptrdiff_t>(orders.count),
                    [&](const net::Order& o) { return o.robot == 3 && net::apart_m(o.goal, *goal) < 0.75; })
            ? 1
            : 0;
  }
  CHECK(assigned > 0);
  // Orders may have come since it looked.
  CHECK(by_new_leader >= assigned - 10);
}

TEST_CASE("who is cut off goes on alone, and comes back", "[net][team]") {
  TeamFleetOptions options = team_of(4, 0.1, 13);
  options.places = 60;
  TeamFleet team(options);
  team.run(6 * kTalkSecond_ns);
  team.fleet().set_group(3, 1);
  team.run(8 * kTalkSecond_ns);
  REQUIRE(team.is_settled());
  CHECK(team.talk(3).cluster().is_leader());
  CHECK(team.talk(3).sight().count == 3);
  for (std::uint32_t i = 0; i < 3; ++i) CHECK_FALSE(team.respects(3, i + 1));
  CHECK_FALSE(team.respects(0, 4));
  CHECK(team.respects(0, 2));
  CHECK_FALSE(team.talk(3).sight().assigned);
  CHECK(team.word(3).has_goal);
  team.fleet().join_all();
  team.run(4 * kTalkSecond_ns);
  REQUIRE(team.is_settled());
  CHECK((team.respects(3, 1) || team.respects(3, 2)));
}

TEST_CASE("what a dead robot claimed is free within five seconds", "[net][team]") {
  const double loss = GENERATE(0.0, 0.3);
  std::vector<hal::TimeNs> times;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) times.push_back(claim_outlives_ns(loss, seed));
  CHECK(p99_s(times) <= 5.0);
}

TEST_CASE("the same of hundreds of dead robots", "[net][team][.soak]") {
  const double loss = GENERATE(0.0, 0.3);
  std::vector<hal::TimeNs> times;
  for (std::uint64_t seed = 1; seed <= 500; ++seed) times.push_back(claim_outlives_ns(loss, seed));
  std::sort(times.begin(), times.end());
  WARN(100 * loss << " % lost: free after " << static_cast<double>(times[times.size() / 2]) * 1e-9 << " s (median), "
                  << p99_s(times) << " (p99), " << static_cast<double>(times.back()) * 1e-9 << " (most)");
  CHECK(p99_s(times) <= 5.0);
}

TEST_CASE("a team at rest says nothing but that it is there", "[net][team]") {
  TeamFleetOptions options = team_of(4, 0.0, 14);
  options.places = 0;
  TeamFleet team(options);
  team.run(10 * kTalkSecond_ns);
  REQUIRE(team.is_settled());
  const std::uint64_t before = team.fleet().sent_bytes();
  team.run(20 * kTalkSecond_ns);
  CHECK(static_cast<double>(team.fleet().sent_bytes() - before) / 20.0 / 4.0 <= 200.0);
}

TEST_CASE("whatever happens to a team, each group gets one leader, who sends no two to one place", "[net][team]") {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) check_team(seed);
}

TEST_CASE("the same in ten thousand teams", "[net][team][.soak]") {
  for (std::uint64_t seed = 11; seed <= 10'010; ++seed) check_team(seed);
}
