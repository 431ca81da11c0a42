// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/speed_limits.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

namespace {

using namespace g3d::hal;
using namespace g3d::hal::kobuki;

constexpr double kTick_s = 0.02;
constexpr double kTiny = 1e-9;

TEST_CASE("too fast a twist is scaled, its curvature kept") {
  const SpeedLimits limits;
  CHECK(limits.scaled({0.3, 0.5}) == Twist{0.3, 0.5});
  for (const Twist wanted : {Twist{2.0, 1.0}, Twist{-0.3, 7.0}, Twist{0.69, -1.5}, Twist{1e5, 1e5}}) {
    const Twist scaled = limits.scaled(wanted);
    CHECK(std::abs(scaled.forward_mps) <= kMaxSpeed_mps + kTiny);
    CHECK(std::abs(scaled.turn_radps) <= kMaxTurn_radps + kTiny);
    CHECK(std::abs(scaled.forward_mps) + std::abs(scaled.turn_radps) * kWheelBase_m / 2 <= kMaxSpeed_mps + kTiny);
    CHECK(scaled.forward_mps * wanted.turn_radps == Approx(scaled.turn_radps * wanted.forward_mps));
    CHECK(scaled.forward_mps * wanted.forward_mps > 0.0);
  }
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  CHECK(limits.scaled({nan, 1.0}) == Twist{});
  CHECK(limits.scaled({0.1, inf}) == Twist{});
}

TEST_CASE("speed and turn grow at their rates") {
  SpeedLimits straight;
  CHECK(straight.limit({0.5, 0.0}, kTick_s).forward_mps == Approx(0.01));
  for (int i = 1; i < 50; ++i) (void)straight.limit({0.5, 0.0}, kTick_s);
  CHECK(straight.driven().forward_mps == Approx(0.5));
  CHECK(straight.limit({0.0, 0.0}, kTick_s).forward_mps == Approx(0.488));
  SpeedLimits spot;
  CHECK(spot.limit({0.0, 1.0}, kTick_s).turn_radps == Approx(0.07));
  for (int i = 0; i < 30; ++i) (void)spot.limit({0.0, 1.0}, kTick_s);
  CHECK(spot.driven() == Twist{0.0, 1.0});
  CHECK(spot.limit({0.0, 0.0}, kTick_s).turn_radps == Approx(1.0 - 0.084));
}

TEST_CASE("from rest the base is on the wanted arc at once and stays on it, braking too") {
  for (const Twist wanted : {Twist{0.5, 0.5}, Twist{0.3, -1.2}, Twist{-0.2, 0.4}, Twist{0.1, 0.6}}) {
    SpeedLimits limits;
    for (int i = 0; i < 100; ++i) {
      const Twist driven = limits.limit(wanted, kTick_s);
      CHECK(driven.forward_mps * wanted.turn_radps == Approx(driven.turn_radps * wanted.forward_mps).margin(kTiny));
    }
    CHECK(limits.driven() == wanted);
    for (int i = 0; i < 100; ++i) {
      const Twist driven = limits.limit({}, kTick_s);
      CHECK(driven.forward_mps * wanted.turn_radps == Approx(driven.turn_radps * wanted.forward_mps).margin(1e-3));
    }
    CHECK(limits.driven() == Twist{});
  }
}

TEST_CASE("while it speeds up, a base follows a new curvature before it gets faster") {
  SpeedLimits limits;
  for (int i = 0; i < 10; ++i) (void)limits.limit({0.7, 0.0}, kTick_s);
  const double before_mps = limits.driven().forward_mps;
  // 1.9 / 0.4 per metre: at 0.1 m/s that is 0.475 rad/s, seven ticks away.
  for (int i = 0; i < 6; ++i) CHECK(limits.limit({0.4, 1.9}, kTick_s).forward_mps == Approx(before_mps));
  for (int i = 0; i < 4; ++i) (void)limits.limit({0.4, 1.9}, kTick_s);
  CHECK(limits.driven().turn_radps / limits.driven().forward_mps == Approx(1.9 / 0.4));
  CHECK(limits.driven().forward_mps > before_mps);
}

TEST_CASE("braking waits for nothing") {
  SpeedLimits limits;
  limits.assume({0.5, 1.5});
  CHECK(limits.limit({0.1, -1.9}, kTick_s).forward_mps == Approx(0.488));
  CHECK(limits.limit({0.0, -1.9}, kTick_s).forward_mps == Approx(0.476));
}

TEST_CASE("no change is faster than allowed, whatever is wanted, and what is wanted is reached") {
  SpeedLimits limits;
  std::uint32_t seed = 1;
  const auto random = [&seed] {
    seed = seed * 1664525U + 1013904223U;
    return static_cast<double>(seed >> 8) / (1U << 24U) * 2.0 - 1.0;
  };
  for (int i = 0; i < 300; ++i) {
    const Twist wanted = limits.scaled({random(), 2.5 * random()});
    int ticks = 0;
    for (; ticks < 200 && limits.driven() != wanted; ++ticks) {
      const Twist before = limits.driven();
      const Twist after = limits.limit(wanted, kTick_s);
      const auto change_allowed = [](double from, double to, double up, double down) {
        const bool shrinks = from * to >= 0.0 && std::abs(to) < std::abs(from);
        return std::abs(to - from) <= (shrinks || from * to < 0.0 ? down : up) * kTick_s + kTiny;
      };
      CAPTURE(before.forward_mps, before.turn_radps, after.forward_mps, after.turn_radps, wanted.forward_mps,
              wanted.turn_radps);
      REQUIRE(change_allowed(before.forward_mps, after.forward_mps, 0.5, 0.6));
      REQUIRE(change_allowed(before.turn_radps, after.turn_radps, 3.5, 4.2));
      REQUIRE(std::abs(after.forward_mps) + std::abs(after.turn_radps) * kWheelBase_m / 2 <= kMaxSpeed_mps + kTiny);
      REQUIRE(std::abs(after.turn_radps) <= kMaxTurn_radps + kTiny);
    }
    CAPTURE(wanted.forward_mps, wanted.turn_radps, limits.driven().forward_mps, limits.driven().turn_radps);
    CHECK(ticks < 200);
  }
}

TEST_CASE("a stop is at once") {
  SpeedLimits limits;
  limits.assume({0.7, 0.0});
  CHECK(limits.stop() == Twist{});
  CHECK(limits.driven() == Twist{});
  CHECK(limits.limit({0.7, 0.0}, kTick_s).forward_mps == Approx(0.01));
}

TEST_CASE("a late caller causes no jump, and no time changes nothing") {
  SpeedLimits limits;
  CHECK(limits.limit({0.7, 0.0}, 5.0).forward_mps == Approx(0.05));
  const Twist before = limits.driven();
  CHECK(limits.limit({0.7, 0.0}, 0.0) == before);
  CHECK(limits.limit({0.7, 0.0}, -1.0) == before);
  CHECK(limits.limit({0.7, 0.0}, std::numeric_limits<double>::quiet_NaN()) == before);
}

TEST_CASE("what is no number brakes") {
  SpeedLimits limits;
  limits.assume({0.5, 0.0});
  CHECK(limits.limit({std::numeric_limits<double>::quiet_NaN(), 0.0}, kTick_s).forward_mps == Approx(0.488));
}

}  // namespace
