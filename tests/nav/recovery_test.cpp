// SPDX-License-Identifier: Apache-2.0
#include "nav/recovery.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

using namespace g3d;
using nav::Recovery;
using nav::RecoveryPhase;
using nav::RecoveryView;
using nav::Trouble;

namespace {

constexpr double kStep_s = 0.02;

/// Carries out what the recovery commands, at once; or not at all, when `is_stuck`.
struct Body {
  Recovery recovery{nav::RecoveryConfig{}};
  RecoveryView view;
  double backed_m = 0.0, turned_rad = 0.0, fastest_back_mps = 0.0;
  bool is_stuck = false;
  std::vector<RecoveryPhase> phases;

  Body() { view.free_behind_m = 1.0; }
  void step() {
    const hal::Twist twist = recovery.step(view);
    if (phases.empty() || phases.back() != recovery.phase()) phases.push_back(recovery.phase());
    view.now_ns += static_cast<nav::TimeNs>(kStep_s * 1e9);
    if (is_stuck) return;
    REQUIRE(twist.forward_mps <= 0.0);
    backed_m -= twist.forward_mps * kStep_s;
    turned_rad += std::fabs(twist.turn_radps) * kStep_s;
    fastest_back_mps = std::max(fastest_back_mps, -twist.forward_mps);
    view.free_behind_m += twist.forward_mps * kStep_s;
    auto& pose = view.T_world_base;
    pose.x_m += twist.forward_mps * kStep_s * std::cos(pose.heading_rad);
    pose.y_m += twist.forward_mps * kStep_s * std::sin(pose.heading_rad);
    pose.heading_rad = nav::wrap_angle(pose.heading_rad + twist.turn_radps * kStep_s);
  }
  /// Until it asks or gives up; false if it does neither within the time.
  bool asks_within(double limit_s) {
    const nav::TimeNs until_ns = view.now_ns + static_cast<nav::TimeNs>(limit_s * 1e9);
    while (view.now_ns < until_ns) {
      step();
      if (recovery.phase() == RecoveryPhase::asking || recovery.phase() == RecoveryPhase::gave_up) return true;
    }
    return false;
  }
  [[nodiscard]] double time_s() const { return static_cast<double>(view.now_ns) * 1e-9; }
};

}  // namespace

TEST_CASE("After a contact it backs off slowly, then asks for a path") {
  Body body;
  body.recovery.start(Trouble::contact, 0.0, body.view);
  REQUIRE(body.asks_within(5));
  CHECK(body.backed_m == Approx(0.15).margin(0.03));
  CHECK(body.fastest_back_mps <= 0.1);
  CHECK(body.turned_rad == 0.0);
  body.recovery.answer(true, body.view);
  CHECK_FALSE(body.recovery.is_active());
  CHECK(body.recovery.step(body.view) == hal::Twist{});
}

TEST_CASE("It backs off only as far as the floor behind is known to be free") {
  Body body;
  body.view.free_behind_m = 0.07;
  body.recovery.start(Trouble::contact, 0.0, body.view);
  REQUIRE(body.asks_within(5));
  CHECK(body.backed_m < 0.07);
  CHECK(body.backed_m > 0.03);
  Body cornered;
  cornered.view.free_behind_m = 0.0;
  cornered.recovery.start(Trouble::contact, 0.0, cornered.view);
  REQUIRE(cornered.asks_within(5));
  CHECK(cornered.backed_m == 0.0);
}

TEST_CASE("What stands in the way may walk away: it waits before it does anything else") {
  Body body;
  body.recovery.start(Trouble::shut, 0.0, body.view);
  REQUIRE(body.asks_within(5));
  CHECK(body.time_s() >= 2.0);
  CHECK(body.backed_m == 0.0);
  CHECK(body.turned_rad == 0.0);
}

TEST_CASE("Without a path it tries one thing after another and then gives up") {
  for (const Trouble trouble : {Trouble::contact, Trouble::shut, Trouble::no_progress, Trouble::no_path}) {
    for (const bool is_stuck : {false, true}) {
      Body body;
      body.is_stuck = is_stuck;
      body.recovery.start(trouble, 1.0, body.view);
      int asked = 0;
      while (body.recovery.phase() != RecoveryPhase::gave_up) {
        REQUIRE(body.asks_within(30));
        if (body.recovery.phase() == RecoveryPhase::gave_up) break;
        ++asked;
        body.recovery.answer(false, body.view);
      }
      CAPTURE(static_cast<int>(trouble), is_stuck);
      CHECK(asked >= 2);
      CHECK(asked <= 4);
      CHECK(body.time_s() < 60.0);
      if (!is_stuck) CHECK(body.turned_rad > 6.2);  // looked all around
      if (!is_stuck) CHECK(body.backed_m > 0.25);
      CHECK(body.recovery.step(body.view) == hal::Twist{});
      body.recovery.reset();
      CHECK_FALSE(body.recovery.is_active());
    }
  }
}

TEST_CASE("Trouble again at the same place is the same trouble, and ends as well") {
  Body body;
  int starts = 0;
  while (body.recovery.phase() != RecoveryPhase::gave_up && starts < 20) {
    body.recovery.start(Trouble::shut, -1.0, body.view);
    ++starts;
    if (body.recovery.phase() == RecoveryPhase::gave_up) break;
    REQUIRE(body.asks_within(30));
    body.recovery.answer(true, body.view);  // there is a path, and it is shut again at once
  }
  CHECK(body.recovery.phase() == RecoveryPhase::gave_up);
  CHECK(starts <= 5);
}

TEST_CASE("Trouble elsewhere is a new one") {
  Body body;
  body.recovery.start(Trouble::shut, 0.0, body.view);
  REQUIRE(body.asks_within(30));
  body.recovery.answer(true, body.view);
  body.view.T_world_base.x_m += 2.0;
  body.recovery.start(Trouble::shut, 0.0, body.view);
  CHECK(body.recovery.attempts() == 0);
}

TEST_CASE("It turns away from the side that was touched") {
  for (const double side : {1.0, -1.0}) {
    Body body;
    body.recovery.start(Trouble::contact, side, body.view);
    REQUIRE(body.asks_within(10));
    body.recovery.answer(false, body.view);
    REQUIRE(body.asks_within(10));
    CHECK(body.view.T_world_base.heading_rad * side < -1.0);
  }
}

TEST_CASE("A turn that presses the bumper again and again is not begun again and again") {
  Body body;
  body.view.free_behind_m = 0.0;
  body.recovery.start(Trouble::contact, 1.0, body.view);
  int contacts = 1;
  while (body.time_s() < 60 && body.recovery.phase() != RecoveryPhase::gave_up) {
    const double turned_rad = body.turned_rad;
    while (body.recovery.is_active() && body.recovery.phase() != RecoveryPhase::gave_up &&
           body.turned_rad - turned_rad < 0.5 && body.time_s() < 60) {
      if (body.recovery.phase() == RecoveryPhase::asking) body.recovery.answer(false, body.view);
      body.step();
    }
    if (body.recovery.phase() == RecoveryPhase::turning) {
      body.recovery.start(Trouble::contact, contacts++ % 2 == 0 ? 1.0 : -1.0, body.view);
    }
  }
  CHECK(body.recovery.phase() == RecoveryPhase::gave_up);
  CHECK(contacts <= 4);
  CHECK(body.time_s() < 20);
}
