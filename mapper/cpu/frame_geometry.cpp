// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/frame_geometry.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::mapper::cpu {
namespace {

std::uint16_t to_raw(float metres, float units_per_metre) {
  return static_cast<std::uint16_t>(std::clamp(std::nearbyint(metres * units_per_metre), 1.0F, 65535.0F));
}

// Corners of the far rectangle in the camera frame, at the outer edges of the outermost pixels.
std::array<std::array<float, 3>, 4> far_corners_m(const SensorGeometry& sensor) {
  const hal::CameraModel& c = sensor.camera;
  const float z = static_cast<float>(sensor.far_raw) * sensor.metres_per_unit;
  const float left = (-0.5F - c.cx_px) / c.fx_px * z;
  const float right = (static_cast<float>(c.width_px) - 0.5F - c.cx_px) / c.fx_px * z;
  const float top = (-0.5F - c.cy_px) / c.fy_px * z;
  const float bottom = (static_cast<float>(c.height_px) - 0.5F - c.cy_px) / c.fy_px * z;
  return {{{left, top, z}, {right, top, z}, {left, bottom, z}, {right, bottom, z}}};
}

}  // namespace

SensorGeometry::SensorGeometry(const hal::CameraModel& model, float resolution, float near_m, float far_m)
    : camera(model),
      resolution_m(resolution),
      near_raw(to_raw(near_m, model.depth_units_per_metre)),
      far_raw(to_raw(far_m, model.depth_units_per_metre)),
      metres_per_unit(1.0F / model.depth_units_per_metre) {
  for (int u = 0; u < model.width_px; ++u) column_slope.push_back((static_cast<float>(u) - model.cx_px) / model.fx_px);
  for (int v = 0; v < model.height_px; ++v) row_slope.push_back((static_cast<float>(v) - model.cy_px) / model.fy_px);
  max_side_blocks = static_cast<int>(longest_side_blocks(model, resolution, far_m));
}

// Whatever the rotation, no side of the box exceeds the largest distance between two corners of the frustum.
double longest_side_blocks(const hal::CameraModel& camera, double resolution_m, double far_m) {
  const double left = (-0.5 - camera.cx_px) / camera.fx_px;
  const double right = (camera.width_px - 0.5 - camera.cx_px) / camera.fx_px;
  const double top = (-0.5 - camera.cy_px) / camera.fy_px;
  const double bottom = (camera.height_px - 0.5 - camera.cy_px) / camera.fy_px;
  double diameter_m = far_m * std::hypot(right - left, bottom - top);
  for (const double x : {left, right}) {
    for (const double y : {top, bottom}) diameter_m = std::max(diameter_m, far_m * std::hypot(x, y, 1.0));
  }
  return std::ceil(diameter_m / (8.0 * resolution_m)) + 3.0;
}

std::optional<FrameGeometry> frame_geometry(const SensorGeometry& sensor, const hal::RigidTransform& T_world_camera) {
  FrameGeometry frame;
  frame.rotation = T_world_camera.rotation;
  frame.translation_m = T_world_camera.translation_m;
  const auto& R = frame.rotation;
  const auto& t = frame.translation_m;
  const auto corners = far_corners_m(sensor);
  std::array<std::int32_t, 3> lowest;
  std::array<std::int32_t, 3> highest;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    float low = t[axis];
    float high = t[axis];
    for (const auto& c : corners) {
      const float x = R[3 * axis] * c[0] + R[3 * axis + 1] * c[1] + R[3 * axis + 2] * c[2] + t[axis];
      low = std::min(low, x);
      high = std::max(high, x);
    }
    const float limit_m = 32760.0F * sensor.resolution_m;
    if (!(low > -limit_m && high < limit_m)) return std::nullopt;
    const Grid grid{sensor.resolution_m};
    // Two voxels to spare: rounding may carry a point past the corner, and a ray one step past its end.
    lowest[axis] = (grid.to_index(low) - 2) & ~7;
    highest[axis] = (grid.to_index(high) + 2) | 7;
    if (!is_inside_grid(lowest[axis]) || !is_inside_grid(highest[axis])) return std::nullopt;
  }
  frame.origin = {lowest[0], lowest[1], lowest[2]};
  frame.nx_blocks = (highest[0] - lowest[0] + 1) / 8;
  frame.ny_blocks = (highest[1] - lowest[1] + 1) / 8;
  frame.nz_blocks = (highest[2] - lowest[2] + 1) / 8;
  return frame;
}

}  // namespace g3d::mapper::cpu
