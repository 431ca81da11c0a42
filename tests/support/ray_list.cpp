// SPDX-License-Identifier: Apache-2.0
#include "tests/support/ray_list.hpp"

#include <cmath>

namespace g3d::test {

RayList ray_list(const hal::CameraModel& camera, const std::uint16_t* depth, const hal::Pose& T_world_camera,
                 float near_m, float far_m) {
  const hal::RigidTransform T = hal::to_transform(T_world_camera);
  const auto near_raw = static_cast<std::uint16_t>(std::lround(near_m * camera.depth_units_per_metre));
  const auto far_raw = static_cast<std::uint16_t>(std::lround(far_m * camera.depth_units_per_metre));
  const float metres_per_unit = 1.0F / camera.depth_units_per_metre;
  RayList list;
  list.origin_m = T.translation_m;
  for (int v = 0; v < camera.height_px; ++v) {
    const float slope_v = (static_cast<float>(v) - camera.cy_px) / camera.fy_px;
    for (int u = 0; u < camera.width_px; ++u) {
      const std::uint16_t raw = depth[v * camera.width_px + u];
      if (raw < near_raw) continue;
      const bool is_far = raw > far_raw;
      const float z = static_cast<float>(is_far ? far_raw : raw) * metres_per_unit;
      const float slope_u = (static_cast<float>(u) - camera.cx_px) / camera.fx_px;
      std::array<float, 3> p;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float row_part = T.rotation[3 * axis + 1] * slope_v + T.rotation[3 * axis + 2];
        p[axis] = (row_part + slope_u * T.rotation[3 * axis]) * z + T.translation_m[axis];
      }
      (is_far ? list.far_m : list.hits_m).push_back(p);
    }
  }
  return list;
}

}  // namespace g3d::test
