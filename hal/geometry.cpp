// SPDX-License-Identifier: Apache-2.0
// What of poses is not needed at every turn. Only from_xyz_rpy needs sine and cosine.
#include "hal/geometry.hpp"

#include <cmath>

namespace g3d::hal {
namespace {

// A text file with six rounded digits stays far inside; a quaternion of another convention does not.
constexpr double kQuaternionNormTolerance = 0.01;

// Each halving of the arc makes the error of the last, linear step 8 times smaller: below 1e-14 rad for half a turn.
constexpr int kSlerpHalvings = 16;

// Shepperd's method: divides by the largest of the four components, so it never loses digits.
algebra::Quaternion to_quaternion(const algebra::Matrix3& m) {
  const double trace = m[0] + m[4] + m[8];
  algebra::Quaternion q{};
  if (trace > 0) {
    q = {m[7] - m[5], m[2] - m[6], m[3] - m[1], 1 + trace};
  } else if (m[0] >= m[4] && m[0] >= m[8]) {
    q = {1 + m[0] - m[4] - m[8], m[1] + m[3], m[2] + m[6], m[7] - m[5]};
  } else if (m[4] >= m[8]) {
    q = {m[1] + m[3], 1 - m[0] + m[4] - m[8], m[5] + m[7], m[2] - m[6]};
  } else {
    q = {m[2] + m[6], m[5] + m[7], 1 - m[0] - m[4] + m[8], m[3] - m[1]};
  }
  return algebra::scaled_to_unit(q);
}

algebra::Vector3 cross(const algebra::Vector3& a, const algebra::Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double norm(const algebra::Vector3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

// The middle of an arc is the normalised sum of its ends, exactly; so halve towards `fraction`, then go straight.
algebra::Quaternion slerp(algebra::Quaternion from, algebra::Quaternion to, double fraction) {
  if (algebra::dot(from, to) < 0) to = {-to[0], -to[1], -to[2], -to[3]};
  for (int i = 0; i < kSlerpHalvings; ++i) {
    const algebra::Quaternion middle =
        algebra::scaled_to_unit({from[0] + to[0], from[1] + to[1], from[2] + to[2], from[3] + to[3]});
    if (fraction < 0.5) {
      to = middle;
      fraction = 2 * fraction;
    } else {
      from = middle;
      fraction = 2 * fraction - 1;
    }
  }
  algebra::Quaternion q{};
  for (std::size_t i = 0; i < 4; ++i) q[i] = from[i] + fraction * (to[i] - from[i]);
  return algebra::scaled_to_unit(q);
}

}  // namespace

bool is_valid(const Pose& pose) {
  for (const double t_m : pose.translation_m) {
    if (!std::isfinite(t_m)) return false;
  }
  // A NaN or an infinity makes the comparison false.
  const double norm_q = std::sqrt(algebra::dot(pose.rotation_xyzw, pose.rotation_xyzw));
  return std::abs(norm_q - 1.0) <= kQuaternionNormTolerance;
}

Pose interpolate(const Pose& from, const Pose& to, double fraction) {
  Pose pose;
  for (std::size_t i = 0; i < 3; ++i) {
    pose.translation_m[i] = from.translation_m[i] + fraction * (to.translation_m[i] - from.translation_m[i]);
  }
  pose.rotation_xyzw =
      slerp(algebra::scaled_to_unit(from.rotation_xyzw), algebra::scaled_to_unit(to.rotation_xyzw), fraction);
  return pose;
}

Pose from_xyz_rpy(double x_m, double y_m, double z_m, double roll_rad, double pitch_rad, double yaw_rad) {
  const algebra::Quaternion roll{std::sin(roll_rad / 2), 0, 0, std::cos(roll_rad / 2)};
  const algebra::Quaternion pitch{0, std::sin(pitch_rad / 2), 0, std::cos(pitch_rad / 2)};
  const algebra::Quaternion yaw{0, 0, std::sin(yaw_rad / 2), std::cos(yaw_rad / 2)};
  return {{x_m, y_m, z_m}, algebra::scaled_to_unit(algebra::multiply(algebra::multiply(yaw, pitch), roll))};
}

Pose look_at(const std::array<double, 3>& eye_m, const std::array<double, 3>& target_m) {
  constexpr algebra::Vector3 kForward{1, 0, 0};
  constexpr algebra::Vector3 kRight{0, -1, 0};
  algebra::Vector3 z{target_m[0] - eye_m[0], target_m[1] - eye_m[1], target_m[2] - eye_m[2]};
  const double distance_m = norm(z);
  if (distance_m > 0) {
    for (double& c : z) c /= distance_m;
  } else {
    z = kForward;
  }
  algebra::Vector3 x = cross(z, {0, 0, 1});
  const double sine = norm(x);
  // Straight up or down there is no horizontal image axis to find; take the one of a camera that looks forward.
  constexpr double kVertical = 1e-9;
  if (sine > kVertical) {
    for (double& c : x) c /= sine;
  } else {
    x = kRight;
    z = {0, 0, z[2] > 0 ? 1.0 : -1.0};
  }
  const algebra::Vector3 y = cross(z, x);
  return {eye_m, to_quaternion({x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]})};
}

}  // namespace g3d::hal
