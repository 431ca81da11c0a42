// SPDX-License-Identifier: Apache-2.0
#include "hal/safety.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

using namespace g3d::hal;

namespace {

constexpr std::uint32_t kCombinations = 1U << kConditionCount;

Conditions only(Condition c) {
  Conditions conditions;
  conditions.set(c);
  return conditions;
}

bool within(const Allowance& a, const Allowance& b) {
  return a.forward_mps <= b.forward_mps && a.backward_mps <= b.backward_mps && a.turn_radps <= b.turn_radps;
}

bool is_still(const Twist& t) { return t.forward_mps == 0.0 && t.turn_radps == 0.0; }

const std::vector<Twist>& wishes() {
  static const std::vector<Twist> all = {{0.7, 0.0},  {0.3, 0.0},   {0.05, 0.0},  {-0.05, 0.0}, {-0.3, 0.0},
                                         {0.0, 2.5},  {0.0, -0.3},  {0.4, 0.9},   {0.4, -1.8},  {-0.1, 0.2},
                                         {-0.2, 1.5}, {0.01, 0.01}, {-2.0, -9.0}, {5.0, 1e-3},  {1e-9, 1.0}};
  return all;
}

}  // namespace

TEST_CASE("Nothing wrong leaves everything") {
  const Verdict verdict = judge({});
  CHECK(verdict.state == SafetyState::free);
  CHECK(verdict.allowance == free_allowance());
  CHECK(verdict.reason == Condition::count_);
  CHECK(free_allowance().forward_mps == 0.70);
  CHECK(free_allowance().turn_radps == 1.9);
}

TEST_CASE("Each condition alone: state, reason, what is left") {
  struct Row {
    Condition condition;
    SafetyState state;
    Condition reason;
    bool forward, backward, turn;
  };
  const Condition none = Condition::count_;
  const std::vector<Row> expected = {
      {Condition::e_stop, SafetyState::stand, Condition::e_stop, false, false, false},
      {Condition::wheel_drop, SafetyState::stand, Condition::wheel_drop, false, false, false},
      {Condition::silent_base, SafetyState::stand, Condition::silent_base, false, false, false},
      {Condition::late_base, SafetyState::stand, Condition::late_base, false, false, false},
      {Condition::late_thread, SafetyState::stand, Condition::late_thread, false, false, false},
      {Condition::stale_command, SafetyState::stand, Condition::stale_command, false, false, false},
      {Condition::silent_camera, SafetyState::stand, Condition::silent_camera, false, false, false},
      {Condition::wrong_firmware, SafetyState::stand, Condition::wrong_firmware, false, false, false},
      {Condition::battery_empty, SafetyState::stand, Condition::battery_empty, false, false, false},
      {Condition::dead_wheel, SafetyState::stand, Condition::dead_wheel, false, false, false},
      {Condition::over_current, SafetyState::stand, Condition::over_current, false, false, false},
      {Condition::cliff, SafetyState::back_off, Condition::cliff, false, true, false},
      {Condition::bumper, SafetyState::back_or_turn, Condition::bumper, false, true, true},
      {Condition::rear_unknown, SafetyState::free, none, true, false, true},
      {Condition::battery_low, SafetyState::careful, Condition::battery_low, true, true, true},
  };
  REQUIRE(expected.size() == kConditionCount);
  for (const Row& row : expected) {
    INFO(to_string(row.condition));
    const Verdict verdict = judge(only(row.condition));
    CHECK(verdict.state == row.state);
    CHECK(verdict.reason == row.reason);
    CHECK((verdict.allowance.forward_mps > 0) == row.forward);
    CHECK((verdict.allowance.backward_mps > 0) == row.backward);
    CHECK((verdict.allowance.turn_radps > 0) == row.turn);
  }
}

TEST_CASE("Pairs whose answer is neither one's own") {
  struct Pair {
    Condition a, b;
    SafetyState state;
    Condition reason;
  };
  for (const Pair& pair :
       {Pair{Condition::bumper, Condition::rear_unknown, SafetyState::turn_only, Condition::bumper},
        Pair{Condition::cliff, Condition::rear_unknown, SafetyState::stand, Condition::cliff},
        Pair{Condition::cliff, Condition::bumper, SafetyState::back_off, Condition::cliff},
        Pair{Condition::battery_low, Condition::bumper, SafetyState::back_or_turn, Condition::bumper},
        Pair{Condition::battery_low, Condition::rear_unknown, SafetyState::careful, Condition::battery_low},
        Pair{Condition::bumper, Condition::wheel_drop, SafetyState::stand, Condition::wheel_drop}}) {
    INFO(to_string(pair.a) << " and " << to_string(pair.b));
    Conditions conditions = only(pair.a);
    conditions.set(pair.b);
    CHECK(judge(conditions).state == pair.state);
    CHECK(judge(conditions).reason == pair.reason);
  }
}

TEST_CASE("Over every combination: one more condition never allows more") {
  std::size_t wrong = 0;
  std::size_t stronger = 0;
  for (std::uint32_t bits = 0; bits < kCombinations; ++bits) {
    const Allowance before = judge({bits}).allowance;
    for (std::size_t i = 0; i < kConditionCount; ++i) {
      Conditions more{bits};
      more.set(static_cast<Condition>(i));
      const Allowance after = judge(more).allowance;
      wrong += !within(after, before);
      stronger += !(after == before);
    }
  }
  CHECK(wrong == 0);
  CHECK(stronger > kConditionCount);  // the comparison above saw differences
}

TEST_CASE("Over every combination: state, reason and allowance say the same") {
  std::size_t wrong = 0;
  std::array<std::size_t, static_cast<std::size_t>(SafetyState::count_)> seen{};
  for (std::uint32_t bits = 0; bits < kCombinations; ++bits) {
    const Verdict v = judge({bits});
    const bool forward = v.allowance.forward_mps > 0, back = v.allowance.backward_mps > 0;
    const bool turn = v.allowance.turn_radps > 0;
    ++seen[static_cast<std::size_t>(v.state)];
    switch (v.state) {
      case SafetyState::stand:
        wrong += forward || back || turn;
        break;
      case SafetyState::turn_only:
        wrong += forward || back || !turn;
        break;
      case SafetyState::back_off:
        wrong += forward || !back || turn;
        break;
      case SafetyState::back_or_turn:
        wrong += forward || !back || !turn;
        break;
      case SafetyState::careful:
        wrong += !forward || v.allowance.forward_mps >= free_allowance().forward_mps;
        break;
      case SafetyState::free:
        wrong += v.allowance.forward_mps != free_allowance().forward_mps;
        break;
      case SafetyState::count_:
        ++wrong;
    }
    wrong += !within(v.allowance, free_allowance());
    wrong += v.allowance.forward_mps < 0 || v.allowance.backward_mps < 0 || v.allowance.turn_radps < 0;
    wrong += (v.reason == Condition::count_) != (v.state == SafetyState::free);
    if (v.reason != Condition::count_) {
      wrong += !Conditions{bits}.has(v.reason);
      // No condition named earlier takes forward motion away.
      for (std::size_t i = 0; i < static_cast<std::size_t>(v.reason); ++i) {
        const Condition earlier = static_cast<Condition>(i);
        wrong +=
            Conditions{bits}.has(earlier) && safety_table()[i].allowance.forward_mps < free_allowance().forward_mps;
      }
    }
  }
  CHECK(wrong == 0);
  for (const std::size_t count : seen) CHECK(count > 0);
}

TEST_CASE("Over every combination: what is permitted is allowed, and no more than with less wrong") {
  std::size_t wrong = 0;
  for (std::uint32_t bits = 0; bits < kCombinations; ++bits) {
    const Allowance a = judge({bits}).allowance;
    for (const Twist& wanted : wishes()) {
      const Twist got = permit(wanted, a);
      wrong += got.forward_mps > a.forward_mps || got.forward_mps < -a.backward_mps;
      wrong += std::abs(got.turn_radps) > a.turn_radps;
      wrong += got.forward_mps * wanted.forward_mps < 0 || got.turn_radps * wanted.turn_radps < 0;
      for (std::size_t i = 0; i < kConditionCount; i += 1 + bits % 3) {
        Conditions more{bits};
        more.set(static_cast<Condition>(i));
        const Twist less = permit(wanted, judge(more).allowance);
        wrong += std::abs(less.forward_mps) > std::abs(got.forward_mps);
        wrong += std::abs(less.turn_radps) > std::abs(got.turn_radps);
      }
    }
  }
  CHECK(wrong == 0);
}

TEST_CASE("What stands, stands for every wish") {
  for (const SafetyRow& row : safety_table()) {
    if (row.allowance.forward_mps > 0 || row.allowance.backward_mps > 0 || row.allowance.turn_radps > 0) continue;
    INFO(to_string(row.condition));
    for (std::uint32_t others = 0; others < kCombinations; others += 37) {
      Conditions conditions{others};
      conditions.set(row.condition);
      for (const Twist& wanted : wishes()) REQUIRE(is_still(permit(wanted, judge(conditions).allowance)));
    }
  }
}

TEST_CASE("Scaling keeps the curvature") {
  const Allowance allowed{0.3, 0.1, 1.0};
  for (const Twist& wanted : wishes()) {
    const Twist got = permit(wanted, allowed);
    REQUIRE_FALSE(is_still(got));
    CHECK(got.forward_mps * wanted.turn_radps == Approx(wanted.forward_mps * got.turn_radps).margin(1e-12));
  }
  CHECK(permit({0.6, 0.5}, allowed).forward_mps == Approx(0.3));
  CHECK(permit({0.6, 0.5}, allowed).turn_radps == Approx(0.25));
  CHECK(permit({0.2, -2.0}, allowed).forward_mps == Approx(0.1));
  CHECK(permit({-0.4, 0.4}, allowed).turn_radps == Approx(0.1));
}

TEST_CASE("What is allowed passes unchanged") {
  for (const Twist& wanted : {Twist{0.7, 1.9}, Twist{-0.2, -1.9}, Twist{0.1, 0.0}, Twist{0.0, 0.0}}) {
    CHECK(permit(wanted, free_allowance()) == wanted);
  }
}

TEST_CASE("A part in a forbidden direction is a stop as a whole") {
  const Allowance no_forward = judge(only(Condition::bumper)).allowance;
  CHECK(is_still(permit({0.1, 0.5}, no_forward)));
  CHECK(is_still(permit({1e-6, 0.5}, no_forward)));
  CHECK(permit({0.0, 0.5}, no_forward).turn_radps == 0.5);
  CHECK(permit({-0.3, 0.0}, no_forward).forward_mps == -0.10);
  const Allowance edge = judge(only(Condition::cliff)).allowance;
  CHECK(is_still(permit({-0.1, 0.1}, edge)));
  CHECK(permit({-0.1, 0.0}, edge).forward_mps == -0.10);
}

TEST_CASE("What is not a number is a stop") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const Twist& wanted : {Twist{nan, 0}, Twist{0, nan}, Twist{inf, 0}, Twist{0.1, -inf}, Twist{nan, inf}}) {
    CHECK(is_still(permit(wanted, free_allowance())));
  }
}

TEST_CASE("A set of conditions holds what was put in") {
  Conditions conditions;
  CHECK(conditions.none());
  conditions.set(Condition::bumper);
  conditions.set(Condition::e_stop);
  CHECK(conditions.has(Condition::bumper));
  CHECK_FALSE(conditions.has(Condition::cliff));
  conditions.set(Condition::bumper, false);
  CHECK(conditions == only(Condition::e_stop));
}

TEST_CASE("Every condition and state has a name of its own") {
  std::set<std::string> names;
  for (std::size_t i = 0; i < kConditionCount; ++i) names.insert(to_string(static_cast<Condition>(i)));
  CHECK(names.size() == kConditionCount);
  CHECK(names.count("none") == 0);
  std::set<std::string> states;
  for (int i = 0; i < static_cast<int>(SafetyState::count_); ++i) states.insert(to_string(static_cast<SafetyState>(i)));
  CHECK(states.size() == static_cast<std::size_t>(SafetyState::count_));
  CHECK(states.count("unknown") == 0);
  CHECK(std::string(to_string(Condition::count_)) == "none");
}
