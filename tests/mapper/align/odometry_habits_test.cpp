// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/odometry_habits.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "mapper/align/pose_step.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper::align;

namespace {

constexpr double kStep_s = 0.1;
constexpr double kSpeed_mps = 0.3;

/// Odometry that turns by `turn_radps` too little and drives too short, corrected in every frame, straight along y.
struct Drive {
  OdometryHabits habits;
  double turn_radps = 0.0;
  double stretch = 0.0;
  double walk_rad = 0.0;  ///< one standard deviation of each step's own error
  tests::Random random{7};

  void on(double time_s, bool holds_shift = false, bool holds_turn = false) {
    for (double t_s = 0.0; t_s < time_s; t_s += kStep_s) {
      const double way_m = kSpeed_mps * kStep_s * (1.0 + habits.stretch());
      const double true_m = kSpeed_mps * kStep_s * (1.0 + stretch);
      const double turn_rad = (turn_radps - habits.turn_radps()) * kStep_s + walk_rad * random.uniform(-1.73, 1.73);
      habits.learn({0.0, true_m - way_m, 0.0, 0.0, 0.0, turn_rad}, {0.0, way_m, 0.0}, kStep_s, holds_shift, holds_turn);
    }
  }
};

}  // namespace

TEST_CASE("odometry that always turns and drives too little is made good") {
  Drive drive;
  drive.turn_radps = 0.0052;
  drive.stretch = -0.02;
  drive.on(10.0);
  CHECK(drive.habits.turn_radps() > 0.5 * 0.0052);
  drive.on(110.0);
  CHECK(drive.habits.turn_radps() == Approx(0.0052).epsilon(0.05));
  CHECK(drive.habits.stretch() == Approx(-0.02).epsilon(0.05));

  const hal::Pose last = hal::from_xyz_rpy(1.0, 2.0, 0.5, 0.0, 0.0, 0.3);
  const hal::Pose step = hal::from_xyz_rpy(0.5, 0.0, 0.0, 0.0, 0.0, 0.1);
  const hal::Pose as_measured = hal::compose(last, step);
  const hal::Pose predicted = drive.habits.predicted(last, step, 2.0);
  const Vector6 off = difference(as_measured, predicted);
  CHECK(off[5] == Approx(2.0 * drive.habits.turn_radps()).epsilon(1e-6));
  CHECK(shift_of(off) == Approx(0.5 * std::abs(drive.habits.stretch())).epsilon(1e-6));
}

TEST_CASE("odometry that is exact, or errs to either side, has no habits") {
  Drive exact;
  exact.on(60.0);
  CHECK(exact.habits.turn_radps() == 0.0);
  CHECK(exact.habits.stretch() == Approx(0.0).margin(1e-12));
  Drive noisy;
  noisy.walk_rad = 0.0087 * std::sqrt(kStep_s);  // half a degree per root second
  noisy.on(120.0);
  CHECK(std::abs(noisy.habits.turn_radps()) < 0.003);
  Drive little;
  little.turn_radps = 0.0009;
  little.stretch = 0.0035;
  little.on(120.0);
  CHECK(little.habits.turn_radps() == 0.0);
  CHECK(little.habits.stretch() == 0.0);
}

TEST_CASE("what the scene does not fix teaches nothing, and what is learnt stays believable") {
  Drive held;
  held.turn_radps = 0.005;
  held.stretch = 0.02;
  held.on(60.0, true, true);
  CHECK(held.habits.turn_radps() == 0.0);
  CHECK(held.habits.stretch() == 0.0);
  held.on(60.0, true, false);
  CHECK(held.habits.turn_radps() > 0.004);
  CHECK(held.habits.stretch() == 0.0);
  Drive absurd;
  absurd.turn_radps = 1.0;
  absurd.stretch = 3.0;
  absurd.on(60.0);
  CHECK(absurd.habits.turn_radps() <= 0.02);
  CHECK(absurd.habits.stretch() <= 0.08);
  OdometryHabits stands;
  stands.learn({0.1, 0, 0, 0, 0, 0}, {0, 0, 0}, kStep_s, false, true);
  CHECK(stands.stretch() == 0.0);
}
