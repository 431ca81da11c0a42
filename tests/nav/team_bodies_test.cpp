// SPDX-License-Identifier: Apache-2.0
#include "nav/team_bodies.hpp"

#include <catch2/catch.hpp>

#include "nav/seconds.hpp"

using namespace g3d;
using nav::after;

namespace {

constexpr hal::TimeNs kTold_ns = 10'000'000'000;

/// Drives east at 0.4 m/s from the origin, 4 m.
nav::Teammate driver() {
  nav::Teammate mate;
  mate.robot = 7;
  mate.told_ns = kTold_ns;
  mate.is_moving = true;
  mate.way[0] = {0.0F, 0.0F, 0.0F};
  mate.way[1] = {4.0F, 0.0F, 10.0F};
  mate.way_count = 2;
  return mate;
}

nav::TeamSight sight_of(const nav::Teammate& mate) {
  nav::TeamSight sight;
  sight.self = 1;
  sight.mates[0] = mate;
  sight.count = 1;
  return sight;
}

}  // namespace

TEST_CASE("a teammate is carried forward along its way by the age of its word", "[nav][team]") {
  const nav::Teammate mate = driver();
  const hal::TimeNs now = after(kTold_ns, 1.0);
  CHECK(nav::place_at(mate, now, now).x_m == Approx(0.4).margin(1e-6));
  CHECK(nav::place_at(mate, now, after(now, 2.0)).x_m == Approx(1.2).margin(1e-6));
  CHECK(nav::place_at(mate, now, after(now, 60.0)).x_m == Approx(4.0).margin(1e-6));
  CHECK(nav::doubt_m(mate, now) > nav::doubt_m(mate, kTold_ns));
}

TEST_CASE("a teammate that stands has not begun its way; one that is silent is where it was", "[nav][team]") {
  nav::Teammate mate = driver();
  mate.is_moving = false;
  const hal::TimeNs now = after(kTold_ns, 1.0);
  CHECK(nav::place_at(mate, now, now).x_m == Approx(0.0).margin(1e-6));
  CHECK(nav::place_at(mate, now, after(now, 1.0)).x_m == Approx(0.4).margin(1e-6));
  mate.is_moving = true;
  const hal::TimeNs late = after(kTold_ns, nav::kTeamWordFresh_s + 0.1);
  CHECK_FALSE(nav::is_under_way(mate, late));
  CHECK(nav::place_at(mate, late, after(late, 5.0)).x_m == Approx(0.0).margin(1e-6));
}

TEST_CASE("where a body is and will be next is taken, and nothing behind it", "[nav][team]") {
  nav::TeamBodies bodies;
  bodies.take(sight_of(driver()));
  const hal::TimeNs now = after(kTold_ns, 2.0);  // it is at x 0.8
  bodies.look_around({0.8, 1.0, 0.0}, now);
  CHECK(bodies.may_be_at(0.8, 0.0));
  CHECK(bodies.may_be_at(0.8 + 0.4 * nav::TeamBodies::kAhead_s, 0.0));
  CHECK_FALSE(bodies.may_be_at(0.2, 0.0));
  CHECK_FALSE(bodies.may_be_at(2.0, 0.0));
  CHECK_FALSE(bodies.may_be_at(0.8, 0.5));
  CHECK(bodies.is_near(0.8, 0.3, 0.2, now));
  CHECK_FALSE(bodies.is_near(0.8, 0.8, 0.2, now));
  bodies.look_around({30.0, 0.0, 0.0}, now);
  CHECK_FALSE(bodies.may_be_at(0.8, 0.0));  // nothing near there
}

TEST_CASE("who drives stands in nobody's way; who is silent does until he is seen to be gone", "[nav][team]") {
  nav::TeamBodies bodies;
  bodies.take(sight_of(driver()));
  int standing = 0;
  const auto count = [&](double, double, double) { ++standing; };
  bodies.for_standing(after(kTold_ns, 1.0), count);
  CHECK(standing == 0);
  const hal::TimeNs silent = after(kTold_ns, 10.0);
  bodies.for_standing(silent, count);
  CHECK(standing == 1);
  // The camera looked through there before the word: that says nothing.
  bodies.forget_gone(silent, [](double, double) { return kTold_ns - 1'000'000'000; });
  bodies.for_standing(silent, count);
  CHECK(standing == 2);
  bodies.forget_gone(silent, [](double, double) { return after(kTold_ns, 5.0); });
  bodies.for_standing(silent, count);
  CHECK(standing == 2);
  bodies.look_around({0.0, 0.0, 0.0}, silent);
  CHECK_FALSE(bodies.may_be_at(0.0, 0.0));
  // It speaks again.
  bodies.take(sight_of(driver()));
  bodies.look_around({0.0, 0.0, 0.0}, kTold_ns);
  CHECK(bodies.may_be_at(0.0, 0.0));
}
