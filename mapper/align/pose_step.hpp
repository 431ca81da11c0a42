// SPDX-License-Identifier: Apache-2.0
// Small steps of a pose, x = (rho, theta): a shift and a turn about the pose's own origin, along the world's axes.
// The tangent of the half angle stands for the half angle (Cayley): the same to third order, and without sine and
// cosine, which differ from one C library to the next.
#pragma once

#include "hal/geometry.hpp"
#include "mapper/align/normal_equations.hpp"

namespace g3d::mapper::align {

[[nodiscard]] inline hal::Pose moved(const hal::Pose& T, const Vector6& x) {
  const hal::Pose turn = hal::normalised({{0, 0, 0}, {0.5 * x[3], 0.5 * x[4], 0.5 * x[5], 1.0}});
  hal::Pose result = hal::compose(turn, {{0, 0, 0}, T.rotation_xyzw});
  for (std::size_t i = 0; i < 3; ++i) result.translation_m[i] = T.translation_m[i] + x[i];
  return result;
}

/// The x that moves `from` to `to`. For turns below half a circle.
[[nodiscard]] inline Vector6 difference(const hal::Pose& from, const hal::Pose& to) {
  const hal::Pose turn = hal::compose({{0, 0, 0}, to.rotation_xyzw}, hal::inverse({{0, 0, 0}, from.rotation_xyzw}));
  const auto& q = turn.rotation_xyzw;
  Vector6 x{};
  for (std::size_t i = 0; i < 3; ++i) {
    x[i] = to.translation_m[i] - from.translation_m[i];
    x[3 + i] = 2.0 * q[i] / q[3];
  }
  return x;
}

[[nodiscard]] inline double shift_of(const Vector6& x) {
  return __builtin_sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}
[[nodiscard]] inline double turn_of(const Vector6& x) {
  return __builtin_sqrt(x[3] * x[3] + x[4] * x[4] + x[5] * x[5]);
}

}  // namespace g3d::mapper::align
