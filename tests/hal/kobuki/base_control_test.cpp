// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/base_control.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

namespace {

using namespace g3d::hal;
using namespace g3d::hal::kobuki;

TEST_CASE("a base drives what was wanted, to the resolution of its numbers") {
  for (int i = -14; i <= 14; ++i) {
    for (int j = -19; j <= 19; ++j) {
      const Twist wanted{0.05 * i, 0.1 * j};
      const Twist driven = to_twist(to_base_control(wanted));
      CAPTURE(wanted.forward_mps, wanted.turn_radps);
      // 1 mm/s of the outer wheel, and 1 mm of radius at the speed of turning.
      CHECK(std::abs(driven.forward_mps - wanted.forward_mps) < 0.001 + 0.001 * std::abs(wanted.turn_radps) + 1e-9);
      CHECK(std::abs(driven.turn_radps - wanted.turn_radps) < 0.02);
    }
  }
}

TEST_CASE("the signs are right in all four quarters") {
  for (const double forward_mps : {-0.3, 0.3}) {
    for (const double turn_radps : {-0.8, 0.8}) {
      const BaseControl control = to_base_control({forward_mps, turn_radps});
      CHECK((control.speed_mmps > 0) == (forward_mps > 0));
      CHECK((control.radius_mm > 0) == (forward_mps * turn_radps > 0));
    }
  }
}

TEST_CASE("a radius too large for 16 bits is straight on") {
  CHECK(to_base_control({0.5, 0.01}) == BaseControl{500, 0});
  CHECK(to_base_control({-0.5, 0.01}) == BaseControl{-500, 0});
  CHECK(to_base_control({0.3, 0.01}).radius_mm == 30'000);
}

TEST_CASE("hardly any speed while turning never turns the wrong way round") {
  for (int i = -80; i <= 80; ++i) {
    for (const double turn_radps : {-1.9, -0.3, 0.3, 1.9}) {
      const BaseControl control = to_base_control({5e-5 * i, turn_radps});
      CAPTURE(i, turn_radps);
      CHECK(control.radius_mm != -1);
      CHECK(control.radius_mm != 0);
      CHECK((to_twist(control).turn_radps > 0) == (turn_radps > 0));
    }
  }
}

TEST_CASE("what is no number is a stop, what is too much is clamped") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const Twist bad : {Twist{nan, 0.0}, Twist{0.0, nan}, Twist{inf, 1.0}, Twist{0.1, -inf}}) {
    CHECK(to_base_control(bad) == BaseControl{});
  }
  CHECK(to_base_control({1e6, 0.0}).speed_mmps == 32'767);
  CHECK(to_base_control({0.0, -1e6}).speed_mmps == -32'768);
}

TEST_CASE("a base reads radius -1 as turning on the spot") {
  CHECK(to_twist({115, -1}).turn_radps == Approx(1.0));
  CHECK(to_twist({115, 1}).turn_radps == Approx(1.0));
  CHECK(to_twist({200, 0}) == Twist{0.2, 0.0});
}

}  // namespace
