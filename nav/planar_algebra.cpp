// SPDX-License-Identifier: Apache-2.0
#include "nav/planar_algebra.hpp"

#include <cmath>

#include "nav/motion_limits.hpp"

namespace g3d::nav {

hal::PlanarPose compose(const hal::PlanarPose& T_a_b, const hal::PlanarPose& T_b_c) {
  const double c = std::cos(T_a_b.heading_rad);
  const double s = std::sin(T_a_b.heading_rad);
  return {T_a_b.x_m + c * T_b_c.x_m - s * T_b_c.y_m, T_a_b.y_m + s * T_b_c.x_m + c * T_b_c.y_m,
          wrap_angle(T_a_b.heading_rad + T_b_c.heading_rad)};
}

hal::PlanarPose inverse(const hal::PlanarPose& T_a_b) {
  const double c = std::cos(T_a_b.heading_rad);
  const double s = std::sin(T_a_b.heading_rad);
  return {-c * T_a_b.x_m - s * T_a_b.y_m, s * T_a_b.x_m - c * T_a_b.y_m, wrap_angle(-T_a_b.heading_rad)};
}

hal::PlanarPose on_plane(const hal::Pose& T_world_base) {
  const auto& q = T_world_base.rotation_xyzw;
  const double heading_rad = std::atan2(2.0 * (q[3] * q[2] + q[0] * q[1]), 1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2]));
  return {T_world_base.translation_m[0], T_world_base.translation_m[1], heading_rad};
}

}  // namespace g3d::nav
