// SPDX-License-Identifier: Apache-2.0
// Rigid poses, written out in + - * / and sqrt: a library product may be vectorised in another order on another
// processor, and then the same log would give another map there. Only from_xyz_rpy needs sine and cosine.
#include "hal/geometry.hpp"

#include <cmath>

namespace g3d::hal {
namespace {

using Vector3 = std::array<double, 3>;
using Quaternion = std::array<double, 4>;  // x y z w
using Matrix3 = std::array<double, 9>;     // row-major

// A text file with six rounded digits stays far inside; a quaternion of another convention does not.
constexpr double kQuaternionNormTolerance = 0.01;

// Each halving of the arc makes the error of the last, linear step 8 times smaller: below 1e-14 rad for half a turn.
constexpr int kSlerpHalvings = 16;

double dot(const Quaternion& a, const Quaternion& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]; }

Quaternion scaled_to_unit(const Quaternion& q) {
  const double norm = std::sqrt(dot(q, q));
  return {q[0] / norm, q[1] / norm, q[2] / norm, q[3] / norm};
}

Quaternion multiply(const Quaternion& a, const Quaternion& b) {
  return {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
          a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

Matrix3 to_matrix(const Quaternion& q) {
  const auto [x, y, z, w] = q;
  return {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
          2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
          2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
}

Vector3 rotate(const Quaternion& q, const Vector3& v) {
  const Matrix3 m = to_matrix(q);
  return {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
          m[6] * v[0] + m[7] * v[1] + m[8] * v[2]};
}

// Shepperd's method: divides by the largest of the four components, so it never loses digits.
Quaternion to_quaternion(const Matrix3& m) {
  const double trace = m[0] + m[4] + m[8];
  Quaternion q{};
  if (trace > 0) {
    q = {m[7] - m[5], m[2] - m[6], m[3] - m[1], 1 + trace};
  } else if (m[0] >= m[4] && m[0] >= m[8]) {
    q = {1 + m[0] - m[4] - m[8], m[1] + m[3], m[2] + m[6], m[7] - m[5]};
  } else if (m[4] >= m[8]) {
    q = {m[1] + m[3], 1 - m[0] + m[4] - m[8], m[5] + m[7], m[2] - m[6]};
  } else {
    q = {m[2] + m[6], m[5] + m[7], 1 - m[0] - m[4] + m[8], m[3] - m[1]};
  }
  return scaled_to_unit(q);
}

Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double norm(const Vector3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

// The middle of an arc is the normalised sum of its ends, exactly; so halve towards `fraction`, then go straight.
Quaternion slerp(Quaternion from, Quaternion to, double fraction) {
  if (dot(from, to) < 0) to = {-to[0], -to[1], -to[2], -to[3]};
  for (int i = 0; i < kSlerpHalvings; ++i) {
    const Quaternion middle = scaled_to_unit({from[0] + to[0], from[1] + to[1], from[2] + to[2], from[3] + to[3]});
    if (fraction < 0.5) {
      to = middle;
      fraction = 2 * fraction;
    } else {
      from = middle;
      fraction = 2 * fraction - 1;
    }
  }
  Quaternion q{};
  for (std::size_t i = 0; i < 4; ++i) q[i] = from[i] + fraction * (to[i] - from[i]);
  return scaled_to_unit(q);
}

}  // namespace

bool is_valid(const Pose& pose) {
  for (const double t_m : pose.translation_m) {
    if (!std::isfinite(t_m)) return false;
  }
  // A NaN or an infinity makes the comparison false.
  const double norm_q = std::sqrt(dot(pose.rotation_xyzw, pose.rotation_xyzw));
  return std::abs(norm_q - 1.0) <= kQuaternionNormTolerance;
}

Pose normalised(const Pose& pose) { return {pose.translation_m, scaled_to_unit(pose.rotation_xyzw)}; }

RigidTransform to_transform(const Pose& pose) {
  const Matrix3 m = to_matrix(scaled_to_unit(pose.rotation_xyzw));
  RigidTransform transform;
  for (std::size_t i = 0; i < 9; ++i) transform.rotation[i] = static_cast<float>(m[i]);
  for (std::size_t i = 0; i < 3; ++i) transform.translation_m[i] = static_cast<float>(pose.translation_m[i]);
  return transform;
}

Pose compose(const Pose& T_a_b, const Pose& T_b_c) {
  const Vector3 moved = rotate(T_a_b.rotation_xyzw, T_b_c.translation_m);
  Pose T_a_c;
  for (std::size_t i = 0; i < 3; ++i) T_a_c.translation_m[i] = T_a_b.translation_m[i] + moved[i];
  T_a_c.rotation_xyzw = scaled_to_unit(multiply(T_a_b.rotation_xyzw, T_b_c.rotation_xyzw));
  return T_a_c;
}

Pose inverse(const Pose& T_a_b) {
  const auto& q = T_a_b.rotation_xyzw;
  const Quaternion conjugate{-q[0], -q[1], -q[2], q[3]};
  const Vector3 moved = rotate(conjugate, T_a_b.translation_m);
  return {{-moved[0], -moved[1], -moved[2]}, conjugate};
}

Pose interpolate(const Pose& from, const Pose& to, double fraction) {
  Pose pose;
  for (std::size_t i = 0; i < 3; ++i) {
    pose.translation_m[i] = from.translation_m[i] + fraction * (to.translation_m[i] - from.translation_m[i]);
  }
  pose.rotation_xyzw = slerp(scaled_to_unit(from.rotation_xyzw), scaled_to_unit(to.rotation_xyzw), fraction);
  return pose;
}

Pose from_xyz_rpy(double x_m, double y_m, double z_m, double roll_rad, double pitch_rad, double yaw_rad) {
  const Quaternion roll{std::sin(roll_rad / 2), 0, 0, std::cos(roll_rad / 2)};
  const Quaternion pitch{0, std::sin(pitch_rad / 2), 0, std::cos(pitch_rad / 2)};
  const Quaternion yaw{0, 0, std::sin(yaw_rad / 2), std::cos(yaw_rad / 2)};
  return {{x_m, y_m, z_m}, scaled_to_unit(multiply(multiply(yaw, pitch), roll))};
}

Pose look_at(const std::array<double, 3>& eye_m, const std::array<double, 3>& target_m) {
  constexpr Vector3 kForward{1, 0, 0};
  constexpr Vector3 kRight{0, -1, 0};
  Vector3 z{target_m[0] - eye_m[0], target_m[1] - eye_m[1], target_m[2] - eye_m[2]};
  const double distance_m = norm(z);
  if (distance_m > 0) {
    for (double& c : z) c /= distance_m;
  } else {
    z = kForward;
  }
  Vector3 x = cross(z, {0, 0, 1});
  const double sine = norm(x);
  // Straight up or down there is no horizontal image axis to find; take the one of a camera that looks forward.
  constexpr double kVertical = 1e-9;
  if (sine > kVertical) {
    for (double& c : x) c /= sine;
  } else {
    x = kRight;
    z = {0, 0, z[2] > 0 ? 1.0 : -1.0};
  }
  const Vector3 y = cross(z, x);
  return {eye_m, to_quaternion({x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]})};
}

}  // namespace g3d::hal
