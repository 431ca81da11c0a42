// SPDX-License-Identifier: Apache-2.0
// Rigid poses. World: x forward, y left, z up, metres. Camera optical frame: x right, y down, z forward.
// `T_parent_child` maps points of the child frame into the parent frame.
#pragma once

#include <array>

#include "hal/pose_algebra.hpp"

namespace g3d::hal {

/// A pose in double precision, as sources publish it. Rotation as a unit quaternion (x, y, z, w).
struct Pose {
  std::array<double, 3> translation_m{0.0, 0.0, 0.0};
  std::array<double, 4> rotation_xyzw{0.0, 0.0, 0.0, 1.0};
};

/// The same as a float32 matrix: what the mapper computes with. Row-major rotation.
struct RigidTransform {
  std::array<float, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::array<float, 3> translation_m{0, 0, 0};
};

/// All seven numbers finite and the quaternion's norm within 1 % of 1 (what a text file with rounded digits gives).
[[nodiscard]] bool is_valid(const Pose& pose);
/// Quaternion rescaled to norm 1. Precondition: is_valid.
[[nodiscard]] inline Pose normalised(const Pose& pose);
[[nodiscard]] inline RigidTransform to_transform(const Pose& pose);
/// T_a_c = T_a_b * T_b_c
[[nodiscard]] inline Pose compose(const Pose& T_a_b, const Pose& T_b_c);
[[nodiscard]] inline Pose inverse(const Pose& T_a_b);
/// Translation linear, rotation slerp along the shorter arc; fraction in [0, 1].
[[nodiscard]] Pose interpolate(const Pose& from, const Pose& to, double fraction);
/// Rotation Rz(yaw) Ry(pitch) Rx(roll), the order of ROS and of `--pose x,y,z,roll,pitch,yaw`. Radians.
[[nodiscard]] Pose from_xyz_rpy(double x_m, double y_m, double z_m, double roll_rad, double pitch_rad, double yaw_rad);
/// Camera at `eye`, optical axis towards `target`, world z up (image y points down as far as possible).
[[nodiscard]] Pose look_at(const std::array<double, 3>& eye_m, const std::array<double, 3>& target_m);

inline Pose normalised(const Pose& pose) { return {pose.translation_m, algebra::scaled_to_unit(pose.rotation_xyzw)}; }

inline RigidTransform to_transform(const Pose& pose) {
  const algebra::Matrix3 m = algebra::to_matrix(algebra::scaled_to_unit(pose.rotation_xyzw));
  RigidTransform transform;
  for (std::size_t i = 0; i < 9; ++i) transform.rotation[i] = static_cast<float>(m[i]);
  for (std::size_t i = 0; i < 3; ++i) transform.translation_m[i] = static_cast<float>(pose.translation_m[i]);
  return transform;
}

inline Pose compose(const Pose& T_a_b, const Pose& T_b_c) {
  const algebra::Vector3 moved = algebra::rotate(T_a_b.rotation_xyzw, T_b_c.translation_m);
  Pose T_a_c;
  for (std::size_t i = 0; i < 3; ++i) T_a_c.translation_m[i] = T_a_b.translation_m[i] + moved[i];
  T_a_c.rotation_xyzw = algebra::scaled_to_unit(algebra::multiply(T_a_b.rotation_xyzw, T_b_c.rotation_xyzw));
  return T_a_c;
}

inline Pose inverse(const Pose& T_a_b) {
  const auto& q = T_a_b.rotation_xyzw;
  const algebra::Quaternion conjugate{-q[0], -q[1], -q[2], q[3]};
  const algebra::Vector3 moved = algebra::rotate(conjugate, T_a_b.translation_m);
  return {{-moved[0], -moved[1], -moved[2]}, conjugate};
}

}  // namespace g3d::hal
