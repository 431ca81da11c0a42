// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/visible_blocks.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::mapper::cpu {

std::array<float, 3> voxel_in_camera_m(const SensorGeometry& sensor, const FrameGeometry& frame,
                                       const VoxelIndex& voxel) {
  const auto& R = frame.rotation;
  const float x = (static_cast<float>(voxel.x) - 32767.5F) * sensor.resolution_m - frame.translation_m[0];
  const float y = (static_cast<float>(voxel.y) - 32767.5F) * sensor.resolution_m - frame.translation_m[1];
  const float z = (static_cast<float>(voxel.z) - 32767.5F) * sensor.resolution_m - frame.translation_m[2];
  return {R[0] * x + R[3] * y + R[6] * z, R[1] * x + R[4] * y + R[7] * z, R[2] * x + R[5] * y + R[8] * z};
}

VisibleBlocks::VisibleBlocks(const SensorGeometry& sensor, const FrameGeometry& frame, const DepthPyramid& pyramid,
                             const Kernels& kernels, float footprint_px_m, float bias_m, const ExactBounds& exact)
    : sensor_(&sensor),
      frame_(&frame),
      pyramid_(&pyramid),
      kernels_(&kernels),
      footprint_px_m_(footprint_px_m),
      bias_m_(bias_m),
      exact_(exact),
      supers_{(frame.nx_blocks + 3) / 4, (frame.ny_blocks + 3) / 4, (frame.nz_blocks + 3) / 4},
      super_view_(box_view(4 * kBlockSide_cells)),
      block_view_(box_view(kBlockSide_cells)),
      brick_view_(box_view(kBlockSide_cells / 2)) {
  const auto& R = frame.rotation;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto offset_m = [&](float x, float y, float z) {
      return sensor.resolution_m * (R[axis] * x + R[3 + axis] * y + R[6 + axis] * z);
    };
    super_middle_m_[axis] = offset_m(15.5F, 15.5F, 15.5F);
    for (std::size_t i = 0; i < 64; ++i) {
      block_middle_m_[axis][i] =
          offset_m(static_cast<float>(8 * (i & 3)) + 3.5F, static_cast<float>(8 * ((i >> 2) & 3)) + 3.5F,
                   static_cast<float>(8 * (i >> 4)) + 3.5F);
    }
    for (std::size_t i = 0; i < 8; ++i) {
      brick_middle_m_[axis][i] =
          offset_m(static_cast<float>(4 * (i & 1)) + 1.5F, static_cast<float>(4 * ((i >> 1) & 1)) + 1.5F,
                   static_cast<float>(4 * (i >> 2)) + 1.5F);
    }
  }
}

BoxView VisibleBlocks::box_view(int side_cells) const {
  const auto& R = frame_->rotation;
  const hal::CameraModel& camera = sensor_->camera;
  const float half_m = 0.5F * sensor_->resolution_m * static_cast<float>(side_cells) + exact_.slack_m;
  BoxView view;
  view.half_x_m = half_m * (std::abs(R[0]) + std::abs(R[3]) + std::abs(R[6]));
  view.half_y_m = half_m * (std::abs(R[1]) + std::abs(R[4]) + std::abs(R[7]));
  view.half_z_m = half_m * (std::abs(R[2]) + std::abs(R[5]) + std::abs(R[8]));
  view.fx_px = camera.fx_px;
  view.fy_px = camera.fy_px;
  view.cx_px = camera.cx_px;
  view.cy_px = camera.cy_px;
  view.last_u_px = static_cast<float>(camera.width_px - 1);
  view.last_v_px = static_cast<float>(camera.height_px - 1);
  view.near_plane_m = 2.0F * sensor_->resolution_m;
  view.far_m = static_cast<float>(sensor_->far_raw) * sensor_->metres_per_unit;
  view.window_px_m = footprint_px_m_;
  view.left_px = -camera.cx_px;
  view.right_px = static_cast<float>(camera.width_px - 1) - camera.cx_px;
  view.top_px = -camera.cy_px;
  view.bottom_px = static_cast<float>(camera.height_px - 1) - camera.cy_px;
  // Rounding moves a voxel by less than this; walking from voxel to voxel strays from the ray by up to one (bresenham).
  const float slack_px_m = 1e-5F * camera.fx_px * view.far_m;
  const auto set_reach = [&](std::size_t i, std::size_t axis, float f, float border) {
    const float cell_px_m = 0.5F * sensor_->resolution_m *
                            (std::abs(f * R[axis] - border * R[2]) + std::abs(f * R[3 + axis] - border * R[5]) +
                             std::abs(f * R[6 + axis] - border * R[8]));
    const int strays_cells = footprint_px_m_ > 0.0F ? 0 : 3;
    view.outer_px_m[i] = static_cast<float>(side_cells + strays_cells) * cell_px_m + slack_px_m;
    view.inner_px_m[i] = static_cast<float>(side_cells - 2) * cell_px_m + slack_px_m;
  };
  set_reach(0, 0, camera.fx_px, view.left_px);
  set_reach(1, 0, camera.fx_px, view.right_px);
  set_reach(2, 1, camera.fy_px, view.top_px);
  set_reach(3, 1, camera.fy_px, view.bottom_px);
  return view;
}

BlockView VisibleBlocks::view(int bx, int by, int bz) const {
  const auto p = voxel_in_camera_m(*sensor_, *frame_,
                                   {frame_->origin.x + 8 * bx, frame_->origin.y + 8 * by, frame_->origin.z + 8 * bz});
  return {bx, by, bz, p[0], p[1], p[2]};
}

std::array<BlockClass, 8> VisibleBlocks::classify_bricks(const BlockView& block) const {
  BoxBounds boxes;
  for (std::size_t i = 0; i < 8; ++i) {
    boxes.x_m[i] = block.x_m + brick_middle_m_[0][i];
    boxes.y_m[i] = block.y_m + brick_middle_m_[1][i];
    boxes.z_m[i] = block.z_m + brick_middle_m_[2][i];
  }
  kernels_->bound_boxes(brick_view_, 8, boxes);
  std::array<BlockClass, 8> classes;
  const float half_z_m = brick_view_.half_z_m;
  for (int i = 0; i < 8; ++i) {
    BlockClass& found = classes[static_cast<std::size_t>(i)];
    BlockView rays;
    // What holds for the rays of the block holds for those of its bricks.
    if (block.farthest_m < boxes.z_m[i] - half_z_m) {
      found = BlockClass::hidden;
    } else if (const float behind = behind_m(boxes.z_m[i], half_z_m);
               block.nearest_m > behind && behind <= exact_.sure_m) {
      found = BlockClass::all_free;
    } else {
      found = decide(boxes, i, brick_view_, rays);
    }
  }
  return classes;
}

BlockClass VisibleBlocks::decide(const BoxBounds& boxes, int i, const BoxView& view, BlockView& rays) const {
  if (boxes.hidden[i] != 0) return BlockClass::hidden;
  const DepthPyramid::Range ends = pyramid_->range(boxes.u0[i], boxes.v0[i], boxes.u1[i], boxes.v1[i]);
  rays.farthest_m = static_cast<float>(ends.max) * sensor_->metres_per_unit;
  if (ends.max == 0 || rays.farthest_m < boxes.z_m[i] - view.half_z_m) return BlockClass::hidden;
  const bool is_inside = boxes.inside[i] != 0;
  if (!is_inside) {
    // Exact rays end at the image's border wherever the voxel reaches.
    return boxes.clear[i] != 0 && footprint_px_m_ > 0.0F ? BlockClass::look : BlockClass::look_at_border;
  }
  // Every window contains its voxel's own pixel: if the rays of all these reach beyond the cube, all voxels are free.
  const float behind = behind_m(boxes.z_m[i], view.half_z_m);
  if ((rays.farthest_m <= behind && &view != &block_view_) || behind > exact_.sure_m) return BlockClass::look;
  const DepthPyramid::Range own =
      pyramid_->range(boxes.centre_u0[i], boxes.centre_v0[i], boxes.centre_u1[i], boxes.centre_v1[i]);
  rays.nearest_m = static_cast<float>(own.min) * sensor_->metres_per_unit;
  return rays.nearest_m > behind ? BlockClass::all_free : BlockClass::look;
}

}  // namespace g3d::mapper::cpu
