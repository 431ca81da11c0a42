// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/plain_trig.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using g3d::hal::sin_cos_deg;

TEST_CASE("sine and cosine agree with the C library") {
  double worst = 0.0;
  for (double angle_deg = -800.0; angle_deg < 800.0; angle_deg += 0.0937) {
    const auto sc = sin_cos_deg(angle_deg);
    const double reduced_rad = std::remainder(angle_deg, 360.0) * 3.14159265358979323846 / 180.0;
    worst = std::max({worst, std::abs(sc.sin - std::sin(reduced_rad)), std::abs(sc.cos - std::cos(reduced_rad))});
  }
  CHECK(worst < 1e-15);
}

TEST_CASE("quarter turns are exact") {
  for (int quarter = -9; quarter <= 9; ++quarter) {
    const auto sc = sin_cos_deg(90.0 * quarter);
    const int phase = ((quarter % 4) + 4) % 4;
    CHECK(sc.sin == (phase == 1 ? 1.0 : phase == 3 ? -1.0 : 0.0));
    CHECK(sc.cos == (phase == 0 ? 1.0 : phase == 2 ? -1.0 : 0.0));
  }
}
