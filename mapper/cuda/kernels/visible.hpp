// SPDX-License-Identifier: Apache-2.0
// What whole boxes of voxels may conclude from the depth pyramid: cpu::VisibleBlocks for one box at a time, operation
// by operation.
#pragma once

#include "mapper/cuda/kernels/common.hpp"

namespace g3d::mapper::cuda {

/// As cpu::BlockClass.
enum class View : std::uint32_t { hidden, look, look_at_border, all_free };

struct BoxBound {
  std::int32_t u0, v0, u1, v1;  ///< columns and rows that any window of the box's voxels touches
  std::int32_t centre_u0, centre_v0, centre_u1, centre_v1;  ///< of its voxels' centres alone
  bool hidden;
  bool inside;
  bool clear;
};

inline G3D_GPU BoxBound bound_box(const cpu::BoxView& b, float x_m, float y_m, float z_m) {
  BoxBound out;
  const float z_low = z_m - b.half_z_m;
  const float z_high = z_m + b.half_z_m;
  const bool projects = z_low > b.near_plane_m;
  const float inverse_low = 1.0F / (projects ? z_low : 1.0F);
  const float inverse_high = 1.0F / (projects ? z_high : 1.0F);
  const float window_px = b.window_px_m * inverse_low;
  const float near_px = 0.7F * window_px + 1.5F;
  const float reach_px = 1.5F * window_px + 2.0F;
  const float x_low = x_m - b.half_x_m;
  const float x_high = x_m + b.half_x_m;
  const float y_low = y_m - b.half_y_m;
  const float y_high = y_m + b.half_y_m;
  const float left = b.fx_px * x_low * (x_low < 0 ? inverse_low : inverse_high) + b.cx_px;
  const float right = b.fx_px * x_high * (x_high > 0 ? inverse_low : inverse_high) + b.cx_px;
  const float top = b.fy_px * y_low * (y_low < 0 ? inverse_low : inverse_high) + b.cy_px;
  const float bottom = b.fy_px * y_high * (y_high > 0 ? inverse_low : inverse_high) + b.cy_px;
  const float x_px_m = b.fx_px * x_m;
  const float y_px_m = b.fy_px * y_m;
  const float from_left = x_px_m - b.left_px * z_m;
  const float from_right = b.right_px * z_m - x_px_m;
  const float from_top = y_px_m - b.top_px * z_m;
  const float from_bottom = b.bottom_px * z_m - y_px_m;
  const bool beside = from_left < -b.outer_px_m[0] || from_right < -b.outer_px_m[1] || from_top < -b.outer_px_m[2] ||
                      from_bottom < -b.outer_px_m[3];
  out.clear = from_left >= b.inner_px_m[0] && from_right >= b.inner_px_m[1] && from_top >= b.inner_px_m[2] &&
              from_bottom >= b.inner_px_m[3];
  const bool within = left >= 0.0F && right <= b.last_u_px && top >= 0.0F && bottom <= b.last_v_px;
  out.hidden = z_high <= 0.0F || z_low > b.far_m || beside;
  out.inside = projects && within;
  const float around_px = within ? near_px : reach_px;
  const float u0 = least(most(left - around_px, 0.0F), b.last_u_px);
  const float v0 = least(most(top - around_px, 0.0F), b.last_v_px);
  const float u1 = least(most(right + around_px, 0.0F), b.last_u_px);
  const float v1 = least(most(bottom + around_px, 0.0F), b.last_v_px);
  const bool whole = out.inside;
  out.centre_u0 = static_cast<std::int32_t>(whole ? left : 0.0F);
  out.centre_v0 = static_cast<std::int32_t>(whole ? top : 0.0F);
  out.centre_u1 = static_cast<std::int32_t>(whole ? least(right + 1.0F, b.last_u_px) : b.last_u_px);
  out.centre_v1 = static_cast<std::int32_t>(whole ? least(bottom + 1.0F, b.last_v_px) : b.last_v_px);
  out.u0 = static_cast<std::int32_t>(projects ? u0 : 0.0F);
  out.v0 = static_cast<std::int32_t>(projects ? v0 : 0.0F);
  out.u1 = static_cast<std::int32_t>(projects ? u1 : b.last_u_px);
  out.v1 = static_cast<std::int32_t>(projects ? v1 : b.last_v_px);
  return out;
}

struct EndRange {
  std::uint32_t min;
  std::uint32_t max;
};

/// Bounds of all ends in columns u0..u1 and rows v0..v1; see cpu::DepthPyramid. Cells above the last level that is kept
/// are gathered from their parts: the same numbers.
inline G3D_GPU EndRange end_range(const FrameParams& f, const Memory& m, int u0, int v0, int u1, int v1) {
  const int extent = most(u1 - u0, v1 - v0);
  int l = 0;
  while ((extent >> (kBaseLevel + l)) >= 3 && l + 1 < f.pyramid_levels) ++l;
  const int kept = least(l, kPyramidLevels - 1);
  const ImageShape& shape = f.shapes[kBaseLevel + kept];
  const std::uint32_t* cells = m.pyramid[kept];
  const int shift = kBaseLevel + l;
  const int parts = l - kept;
  const int x0 = (u0 >> shift) << parts;
  const int y0 = (v0 >> shift) << parts;
  const int x1 = least((((u1 >> shift) + 1) << parts) - 1, shape.width - 1);
  const int y1 = least((((v1 >> shift) + 1) << parts) - 1, shape.height - 1);
  EndRange range{0xFFFFU, 0U};
  if (parts == 0) {
    // At most 4 x 4 cells: sixteen looks at once, some of them at the same cell, cost less than a loop of waits.
#pragma GCC unroll 16
    for (int i = 0; i < 16; ++i) {
      const std::uint32_t cell = cells[least(y0 + i / 4, y1) * shape.width + least(x0 + i % 4, x1)];
      range.min = least(range.min, cell & 0xFFFFU);
      range.max = most(range.max, cell >> 16);
    }
    return range;
  }
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const std::uint32_t cell = cells[y * shape.width + x];
      range.min = least(range.min, cell & 0xFFFFU);
      range.max = most(range.max, cell >> 16);
    }
  }
  return range;
}

/// What is known of the rays that pass a box.
struct RayBounds {
  float farthest_m = 3.4e38F;
  float nearest_m = -3.4e38F;
};

/// How far rays must reach for all voxels of a box to be free.
inline G3D_GPU float behind_m(const FrameParams& f, float z_m, float half_z_m) {
  return z_m + half_z_m + most(f.bias_m, 0.0F) + f.metres_per_unit;
}

inline G3D_GPU View decide(const FrameParams& f, const Memory& m, const cpu::BoxView& view, bool is_block, float x_m,
                           float y_m, float z_m, RayBounds& rays) {
  const BoxBound box = bound_box(view, x_m, y_m, z_m);
  if (box.hidden) return View::hidden;
  const EndRange ends = end_range(f, m, box.u0, box.v0, box.u1, box.v1);
  rays.farthest_m = static_cast<float>(ends.max) * f.metres_per_unit;
  if (ends.max == 0 || rays.farthest_m < z_m - view.half_z_m) return View::hidden;
  if (!box.inside) return box.clear && f.window_px_m > 0.0F ? View::look : View::look_at_border;
  const float behind = behind_m(f, z_m, view.half_z_m);
  if (rays.farthest_m <= behind && !is_block) return View::look;
  const EndRange own = end_range(f, m, box.centre_u0, box.centre_v0, box.centre_u1, box.centre_v1);
  rays.nearest_m = static_cast<float>(own.min) * f.metres_per_unit;
  return rays.nearest_m > behind ? View::all_free : View::look;
}

/// One of a block's eight bricks; see cpu::VisibleBlocks::classify_bricks.
inline G3D_GPU View decide_brick(const FrameParams& f, const Memory& m, const Corner& corner, const RayBounds& block,
                                 int brick) {
  const float x_m = corner.x_m + f.brick_middle_m[0][brick];
  const float y_m = corner.y_m + f.brick_middle_m[1][brick];
  const float z_m = corner.z_m + f.brick_middle_m[2][brick];
  const float half_z_m = f.brick_view.half_z_m;
  if (block.farthest_m < z_m - half_z_m) return View::hidden;
  if (block.nearest_m > behind_m(f, z_m, half_z_m)) return View::all_free;
  RayBounds rays;
  return decide(f, m, f.brick_view, false, x_m, y_m, z_m, rays);
}

inline G3D_GPU View decide_super(const FrameParams& f, const Memory& m, int sx, int sy, int sz) {
  const Corner first = corner_of(f, 4 * sx, 4 * sy, 4 * sz);
  RayBounds rays;
  return decide(f, m, f.super_view, false, first.x_m + f.super_middle_m[0], first.y_m + f.super_middle_m[1],
                first.z_m + f.super_middle_m[2], rays);
}

/// Block i (x fastest) of a group of 4x4x4, whose class is known.
inline G3D_GPU View decide_block(const FrameParams& f, const Memory& m, View super, int sx, int sy, int sz, int i,
                                 RayBounds& rays) {
  if (super == View::hidden || super == View::all_free) return super;
  const Corner first = corner_of(f, 4 * sx, 4 * sy, 4 * sz);
  return decide(f, m, f.block_view, true, first.x_m + m.input->tables.block_middle_m[0][i],
                first.y_m + m.input->tables.block_middle_m[1][i], first.z_m + m.input->tables.block_middle_m[2][i],
                rays);
}

}  // namespace g3d::mapper::cuda
