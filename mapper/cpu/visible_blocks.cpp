// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/visible_blocks.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::mapper::cpu {

std::array<float, 3> voxel_in_camera_m(const SensorGeometry& sensor, const FrameGeometry& frame, const VoxelIndex& voxel) {
  const auto& R = frame.rotation;
  const float x = (static_cast<float>(voxel.x) - 32767.5F) * sensor.resolution_m - frame.translation_m[0];
  const float y = (static_cast<float>(voxel.y) - 32767.5F) * sensor.resolution_m - frame.translation_m[1];
  const float z = (static_cast<float>(voxel.z) - 32767.5F) * sensor.resolution_m - frame.translation_m[2];
  return {R[0] * x + R[3] * y + R[6] * z, R[1] * x + R[4] * y + R[7] * z, R[2] * x + R[5] * y + R[8] * z};
}

VisibleBlocks::VisibleBlocks(const SensorGeometry& sensor, const FrameGeometry& frame, const DepthPyramid& pyramid,
                             float footprint_px_m, float bias_m)
    : sensor_(&sensor), frame_(&frame), pyramid_(&pyramid), footprint_px_m_(footprint_px_m), bias_m_(bias_m) {
  const auto& R = frame.rotation;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    extent_per_voxel_m_[axis] =
        0.5F * sensor.resolution_m * (std::abs(R[axis]) + std::abs(R[3 + axis]) + std::abs(R[6 + axis]));
    diagonal_m_[axis] = sensor.resolution_m * (R[axis] + R[3 + axis] + R[6 + axis]);
  }
  supers_ = {(frame.nx_blocks + 3) / 4, (frame.ny_blocks + 3) / 4, (frame.nz_blocks + 3) / 4};
}

BlockView VisibleBlocks::view(int bx, int by, int bz) const {
  const auto p = voxel_in_camera_m(
      *sensor_, *frame_, {frame_->origin.x + 8 * bx, frame_->origin.y + 8 * by, frame_->origin.z + 8 * bz});
  return {bx, by, bz, p[0], p[1], p[2]};
}

BlockClass VisibleBlocks::classify(const BlockView& first, int side_cells) const {
  const hal::CameraModel& camera = sensor_->camera;
  const float voxels = static_cast<float>(side_cells);
  const float to_centre = 0.5F * (voxels - 1.0F);
  const float ex = extent_per_voxel_m_[0] * voxels;
  const float ey = extent_per_voxel_m_[1] * voxels;
  const float ez = extent_per_voxel_m_[2] * voxels;
  const float x = first.x_m + to_centre * diagonal_m_[0];
  const float y = first.y_m + to_centre * diagonal_m_[1];
  const float z = first.z_m + to_centre * diagonal_m_[2];
  const float z_low = z - ez;
  const float z_high = z + ez;
  const float far_m = static_cast<float>(sensor_->far_raw) * sensor_->metres_per_unit;
  if (z_high <= 0.0F || z_low > far_m) return BlockClass::hidden;

  const float last_u = static_cast<float>(camera.width_px - 1);
  const float last_v = static_cast<float>(camera.height_px - 1);
  const float near_plane_m = 2.0F * sensor_->resolution_m;
  int u0 = 0;
  int v0 = 0;
  int u1 = camera.width_px - 1;
  int v1 = camera.height_px - 1;
  bool is_inside = false;
  if (z_low > near_plane_m) {
    const float inverse_low = 1.0F / z_low;
    const float inverse_high = 1.0F / z_high;
    const float reach_px = footprint_px_m_ * inverse_low + 2.0F;
    const float left = camera.fx_px * (x - ex) * (x - ex < 0 ? inverse_low : inverse_high) + camera.cx_px;
    const float right = camera.fx_px * (x + ex) * (x + ex > 0 ? inverse_low : inverse_high) + camera.cx_px;
    const float top = camera.fy_px * (y - ey) * (y - ey < 0 ? inverse_low : inverse_high) + camera.cy_px;
    const float bottom = camera.fy_px * (y + ey) * (y + ey > 0 ? inverse_low : inverse_high) + camera.cy_px;
    if (right + reach_px < 0.0F || left - reach_px > last_u || bottom + reach_px < 0.0F || top - reach_px > last_v) {
      return BlockClass::hidden;
    }
    is_inside = left >= 0.0F && right <= last_u && top >= 0.0F && bottom <= last_v;
    u0 = static_cast<int>(std::max(left - reach_px, 0.0F));
    v0 = static_cast<int>(std::max(top - reach_px, 0.0F));
    u1 = static_cast<int>(std::min(right + reach_px, last_u));
    v1 = static_cast<int>(std::min(bottom + reach_px, last_v));
  }
  const DepthPyramid::Range ends = pyramid_->range(u0, v0, u1, v1);
  const float farthest_m = static_cast<float>(ends.max) * sensor_->metres_per_unit;
  if (ends.max == 0 || farthest_m < z_low) return BlockClass::hidden;
  const float nearest_m = static_cast<float>(ends.min) * sensor_->metres_per_unit;
  if (is_inside && nearest_m > z_high + std::max(bias_m_, 0.0F) + sensor_->metres_per_unit) return BlockClass::all_free;
  return is_inside ? BlockClass::look : BlockClass::look_at_border;
}

}  // namespace g3d::mapper::cpu
