// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/pose_step.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using namespace g3d::mapper::align;

TEST_CASE("a step and the difference undo each other", "[mapper][align]") {
  const hal::Pose from = hal::from_xyz_rpy(1.0, -2.0, 0.5, 0.3, -0.2, 2.5);
  const Vector6 x{0.05, -0.02, 0.01, 0.03, -0.04, 0.2};
  const Vector6 back = difference(from, moved(from, x));
  for (std::size_t i = 0; i < 6; ++i) CHECK(back[i] == Approx(x[i]).margin(1e-12));
}

TEST_CASE("a small step turns about the world's axes, about the pose's own origin", "[mapper][align]") {
  const hal::Pose from = hal::from_xyz_rpy(1.0, -2.0, 0.5, 0.3, -0.2, 2.5);
  const hal::Pose turned = moved(from, {0, 0, 0, 0, 0, 0.01});
  const hal::Pose expected = hal::from_xyz_rpy(1.0, -2.0, 0.5, 0.3, -0.2, 2.51);
  CHECK(turned.translation_m == from.translation_m);
  const Vector6 off = difference(expected, turned);
  CHECK(turn_of(off) < 1e-6);  // a third of the cube of half the angle
  CHECK(shift_of({3.0, 4.0, 0.0, 9.0, 9.0, 9.0}) == Approx(5.0));
}
