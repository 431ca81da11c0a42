// SPDX-License-Identifier: Apache-2.0
#include "tests/support/trajectory_error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace g3d::test {
namespace {

double angle_deg(const hal::Pose& T) {
  const auto& q = T.rotation_xyzw;
  const double s = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
  return 2.0 * std::atan2(s, std::abs(q[3])) * 180.0 / std::numbers::pi;
}
double length_m(const hal::Pose& T) {
  const auto& t = T.translation_m;
  return std::sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
}
/// T_b_a c, the estimate's step against the true one.
hal::Pose step_error(const hal::Pose& true_step, const hal::Pose& step) {
  return hal::compose(hal::inverse(true_step), step);
}

}  // namespace

TrajectoryError trajectory_error(std::span<const hal::StampedPose> truth, std::span<const hal::StampedPose> estimate) {
  TrajectoryError error;
  const std::size_t n = std::min(truth.size(), estimate.size());
  if (n == 0) return error;
  double shift2 = 0.0;
  double turn2 = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const auto& a = truth[i].T_world_camera;
    const auto& b = estimate[i].T_world_camera;
    const double angle = angle_deg(hal::compose(hal::inverse(a), b));
    for (std::size_t k = 0; k < 3; ++k) {
      const double d = a.translation_m[k] - b.translation_m[k];
      shift2 += d * d;
    }
    turn2 += angle * angle;
    error.last_turn_deg = angle;
  }
  error.ate_m = std::sqrt(shift2 / static_cast<double>(n));
  error.turn_rms_deg = std::sqrt(turn2 / static_cast<double>(n));
  double rpe_turn2 = 0.0;
  double rpe_shift2 = 0.0;
  std::size_t pairs = 0;
  std::size_t j = 0;
  for (std::size_t i = 0; i < n; ++i) {
    while (j < n && truth[j].stamp_ns - truth[i].stamp_ns < 1'000'000'000) ++j;
    if (j == n) break;
    const hal::Pose e = step_error(hal::compose(hal::inverse(truth[i].T_world_camera), truth[j].T_world_camera),
                                   hal::compose(hal::inverse(estimate[i].T_world_camera), estimate[j].T_world_camera));
    rpe_turn2 += angle_deg(e) * angle_deg(e);
    rpe_shift2 += length_m(e) * length_m(e);
    ++pairs;
  }
  if (pairs > 0) {
    error.rpe_turn_deg = std::sqrt(rpe_turn2 / static_cast<double>(pairs));
    error.rpe_shift_m = std::sqrt(rpe_shift2 / static_cast<double>(pairs));
  }
  return error;
}

}  // namespace g3d::test
