// SPDX-License-Identifier: Apache-2.0
#include "nav/spin.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace g3d;

namespace {

constexpr double kFullTurn_rad = 6.283185307179586;
constexpr double kStep_s = 0.05;

/// Turns until the spin is over, as an ideal base would; gives how far it turned.
double turned_rad(nav::Spin& spin, double heading_rad) {
  double sum_rad = 0.0;
  for (int steps = 0; steps < 2000; ++steps) {
    const auto twist = spin.step(nav::wrap_angle(heading_rad + sum_rad), nav::MotionLimits{});
    if (!twist) return sum_rad;
    CHECK(twist->forward_mps == 0.0);
    sum_rad += twist->turn_radps * kStep_s;
  }
  return std::nan("");
}

}  // namespace

TEST_CASE("A spin turns as far as told, whole turns as well, either way, across the seam of the heading") {
  for (const double turn_rad : {kFullTurn_rad, -kFullTurn_rad, 1.5 * kFullTurn_rad, 0.7, -0.7}) {
    nav::Spin spin;
    CHECK_FALSE(spin.is_active());
    spin.start(turn_rad, 3.0);
    CHECK(spin.is_active());
    CHECK(turned_rad(spin, 3.0) == Approx(turn_rad).margin(0.06));
    CHECK_FALSE(spin.is_active());
  }
}

TEST_CASE("Turned too far is turned far enough, and a spin can be given up") {
  nav::Spin spin;
  spin.start(0.5, 0.0);
  CHECK(spin.step(0.1, nav::MotionLimits{}));
  CHECK_FALSE(spin.step(0.7, nav::MotionLimits{}));
  spin.start(0.5, 0.7);
  spin.clear();
  CHECK_FALSE(spin.is_active());
}
