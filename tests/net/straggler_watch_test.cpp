// SPDX-License-Identifier: Apache-2.0
// The watch, and what a fleet of gates makes of it: a rotation of the key from its first robot to its last.
#include "net/straggler_watch.hpp"

#include <catch2/catch.hpp>

#include "tests/support/gate_fleet.hpp"

namespace {

using namespace g3d;
using namespace g3d::net;
using namespace g3d::test;

constexpr hal::TimeNs kMs = hal::kMillisecond_ns;

/// Rounds in which each robot speaks to each other one, 100 ms apart. Returns what was heard in the last of them.
int talk(Air& air, std::vector<GateRobot*> robots, hal::TimeNs& now_ns, int rounds) {
  int heard = 0;
  for (int round = 0; round < rounds; ++round) {
    heard = 0;
    for (GateRobot* from : robots) {
      for (GateRobot* to : robots) {
        if (from != to) heard += air.say(*from, *to, "x", now_ns) ? 1 : 0;
      }
    }
    now_ns += 100 * kMs;
  }
  return heard;
}

TEST_CASE("those who have only the old key are heard of for a while") {
  StragglerWatch watch;
  Envelope envelope;
  const auto hears = [&](bool previous, bool newer) {
    StragglerWatch fresh;
    envelope.previous_epoch = previous;
    envelope.kind.holds_newer = newer;
    fresh.note(envelope, 0);
    watch = fresh;
    return fresh.hears_one(0);
  };
  CHECK_FALSE(watch.hears_one(0));
  CHECK_FALSE(hears(false, false));
  CHECK_FALSE(hears(true, true));
  CHECK(hears(true, false));
  CHECK(watch.hears_one(StragglerWatch::kPatience_ns - 1));
  CHECK_FALSE(watch.hears_one(StragglerWatch::kPatience_ns));
  watch.forget();
  CHECK_FALSE(watch.hears_one(0));
}

TEST_CASE("a fleet goes on talking while its key is rotated, and shuts out the old key afterwards") {
  const FleetKey old = generate_fleet_key();
  FleetKey both = copy_of(old);
  rotate_fleet_key(both, OldKey::kept_until_finished);
  FleetKey finished = copy_of(both);
  finish_rotation(finished);

  const bool restarts = GENERATE(false, true);  // the new key needs no restart, but may be a reason for one
  std::vector<std::unique_ptr<GateRobot>> owned;
  std::vector<GateRobot*> robots;
  for (std::uint64_t i = 0; i < 4; ++i) {
    owned.push_back(std::make_unique<GateRobot>(old, i));
    robots.push_back(owned.back().get());
  }
  const auto give = [&](std::size_t i, const FleetKey& keys) {
    if (!restarts) return robots[i]->gate.use_keys(copy_of(keys));
    owned[i] = std::make_unique<GateRobot>(keys, i);
    robots[i] = owned[i].get();
  };
  Air air;
  hal::TimeNs now_ns = 0;
  REQUIRE(talk(air, robots, now_ns, 5) == 12);
  for (std::size_t i = 0; i < 3; ++i) {
    give(i, both);
    REQUIRE(talk(air, robots, now_ns, 8) == 12);
    CHECK(robots[0]->gate.hears_stragglers(now_ns));
  }
  give(3, both);
  REQUIRE(talk(air, robots, now_ns, 5) == 12);
  REQUIRE(talk(air, robots, now_ns, 110) == 12);
  for (GateRobot* robot : robots) {
    CHECK_FALSE(robot->gate.hears_stragglers(now_ns));
    const std::uint64_t before = robot->gate.counts().sealed_previous;
    (void)seal_text(*robot, "x", now_ns);
    CHECK(robot->gate.counts().sealed_previous == before);
  }
  GateRobot outsider(old, 9);
  CHECK_FALSE(air.say(outsider, *robots[0], "x", now_ns));
  CHECK(air.say(outsider, *robots[0], "the old key still does", now_ns));
  for (std::size_t i = 0; i < 4; ++i) give(i, finished);
  REQUIRE(talk(air, robots, now_ns, 5) == 12);
  for (int i = 0; i < 5; ++i) CHECK_FALSE(air.say(outsider, *robots[0], "x", now_ns));
  CHECK(robots[0]->gate.counts()[GateRefusal::unknown_epoch] == 5);
  CHECK_FALSE(air.say(*robots[0], outsider, "x", now_ns));
}

TEST_CASE("a robot in wrong hands is shut out at once") {
  FleetKey keys = generate_fleet_key();
  GateRobot captured(keys, 1), a(keys, 2), b(keys, 3);
  Air air;
  hal::TimeNs now_ns = 0;
  REQUIRE(talk(air, {&captured, &a, &b}, now_ns, 5) == 6);
  rotate_fleet_key(keys, OldKey::shut_out);
  a.gate.use_keys(copy_of(keys));
  b.gate.use_keys(copy_of(keys));
  CHECK(talk(air, {&a, &b}, now_ns, 1) == 2);
  CHECK_FALSE(air.say(captured, a, "x", now_ns));
  CHECK_FALSE(air.say(a, captured, "x", now_ns));
  CHECK(a.gate.counts()[GateRefusal::unknown_epoch] == 1);
}

TEST_CASE("a recording of one with the old key keeps nobody at it") {
  FleetKey keys = generate_fleet_key();
  GateRobot old(keys, 1), a(keys, 2);
  Air air;
  (void)air.say(old, a, "x", 0);
  const DatagramBytes recorded = seal_text(old, "x", 0);
  REQUIRE(air.carry(old, a, recorded, 0));
  rotate_fleet_key(keys, OldKey::kept_until_finished);
  a.gate.use_keys(copy_of(keys));
  CHECK(a.gate.take(recorded, old.source, 0).reason == GateRefusal::replayed);
  CHECK_FALSE(a.gate.hears_stragglers(0));
  GateRobot restarted(keys, 2);
  CHECK(restarted.gate.take(recorded, old.source, 0).verdict == GateVerdict::answer);
  CHECK_FALSE(restarted.gate.hears_stragglers(0));
}

TEST_CASE("a robot that is revoked while it talks is not heard any more") {
  FleetKey keys = generate_fleet_key();
  GateRobot a(keys, 1), b(keys, 2);
  Air air;
  hal::TimeNs now_ns = 0;
  REQUIRE(talk(air, {&a, &b}, now_ns, 5) == 2);
  REQUIRE(revoke_robot(keys, 1).ok());
  b.gate.use_keys(copy_of(keys));
  for (int i = 0; i < 20; ++i) CHECK_FALSE(air.say(a, b, "x", now_ns += 500 * kMs));
  CHECK(b.gate.counts()[GateRefusal::revoked] > 10);
  CHECK(b.gate.sessions().empty());
}

}  // namespace
