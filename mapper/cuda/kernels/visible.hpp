// SPDX-License-Identifier: Apache-2.0
// What whole boxes of voxels may conclude from the depth pyramid: cpu::VisibleBlocks for one box at a time, operation
// by operation.
#pragma once

#include "mapper/cuda/kernels/reduce.hpp"

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

/// Levels of the pyramid whose cells are larger than a tile: few, so that each block of threads makes its own.
struct TopLevels {
  static constexpr int kMostCells = 32 * 32 + 16 * 16 + 8 * 8 + 4 * 4;  ///< of an image of 2048 x 2048 pixels
  std::uint32_t cells[kMostCells];
};
[[nodiscard]] constexpr int cells_along(int size_px, int level) {
  return (size_px + (1 << (kBaseLevel + level)) - 1) >> (kBaseLevel + level);
}

inline G3D_GPU void make_top(const Block& block, const Memory& m, const FrameParams& f, TopLevels& top) {
  const std::uint32_t* below = m.pyramid[kPyramidLevels - 1];
  std::uint32_t* cells = top.cells;
#pragma GCC unroll 1
  for (int level = kPyramidLevels; level < f.pyramid_levels; ++level) {
    const int width = cells_along(f.width_px, level);
    const int count = width * cells_along(f.height_px, level);
    const int last_x = cells_along(f.width_px, level - 1) - 1;
    const int last_y = cells_along(f.height_px, level - 1) - 1;
    block.each([&](int t) {
      for (int cell = t; cell < count; cell += kPixelThreads) {
        const int x = 2 * (cell % width);
        const int y = 2 * (cell / width);
        const std::uint32_t* upper = below + y * (last_x + 1);
        const std::uint32_t* lower = below + least(y + 1, last_y) * (last_x + 1);
        cells[cell] = join_ends(join_ends(upper[x], upper[least(x + 1, last_x)]),
                                join_ends(lower[x], lower[least(x + 1, last_x)]));
      }
    });
    below = cells;
    cells += count;
  }
}

/// Cells of one level of the pyramid that cover some columns and rows; see cpu::DepthPyramid.
struct CellRange {
  const std::uint32_t* cells;
  std::int32_t width;  ///< of the level
  std::int32_t x0, y0, x1, y1;
};
inline G3D_GPU CellRange cells_of(const FrameParams& f, const Memory& m, const TopLevels& top, int u0, int v0, int u1,
                                  int v1) {
  const int extent = most(u1 - u0, v1 - v0);
  int l = 0;
  while ((extent >> (kBaseLevel + l)) >= 3 && l + 1 < f.pyramid_levels) ++l;
  const std::uint32_t* cells = top.cells;
  if (l < kPyramidLevels) {
    cells = m.pyramid[l];
  } else {
    for (int i = kPyramidLevels; i < l; ++i) cells += cells_along(f.width_px, i) * cells_along(f.height_px, i);
  }
  const int shift = kBaseLevel + l;
  return {cells, cells_along(f.width_px, l), u0 >> shift, v0 >> shift, u1 >> shift, v1 >> shift};
}

/// Lowest and highest end of one thread's share of the cells, when kSharers threads share them: rows, four cells at
/// once.
template <int kSharers>
inline G3D_GPU std::uint32_t gather_ends(const CellRange& r, int sharer) {
  std::uint32_t ends = pack_ends(kNoLow, 0);
  constexpr int kRowsAtOnce = kSharers < 4 ? 4 : 1;
#pragma GCC unroll 1
  for (int y = r.y0 + sharer; y <= r.y1; y += kSharers * kRowsAtOnce) {
#pragma GCC unroll 1
    for (int x = r.x0; x <= r.x1; x += 4) {
#pragma GCC unroll 16
      for (int i = 0; i < 4 * kRowsAtOnce; ++i) {
        ends = join_ends(ends, r.cells[least(y + i / 4 * kSharers, r.y1) * r.width + least(x + i % 4, r.x1)]);
      }
    }
  }
  return ends;
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

/// Ends within what a box covers, as far as they are of account: of all its windows, and of its voxels' own pixels.
template <int kSharers>
inline G3D_GPU void gather_box(const FrameParams& f, const Memory& m, const TopLevels& top, const BoxBound& box,
                               int sharer, std::uint32_t& ends, std::uint32_t& own) {
  ends = pack_ends(kNoLow, 0);
  own = pack_ends(kNoLow, 0);
  if (box.hidden) return;
  const CellRange all = cells_of(f, m, top, box.u0, box.v0, box.u1, box.v1);
  const CellRange inner =
      box.inside ? cells_of(f, m, top, box.centre_u0, box.centre_v0, box.centre_u1, box.centre_v1) : all;
  ends = gather_ends<kSharers>(all, sharer);
  if (box.inside) own = gather_ends<kSharers>(inner, sharer);
}

/// What follows for a box from gather_box(), all shares joined.
inline G3D_GPU View conclude(const FrameParams& f, const cpu::BoxView& view, bool is_block, const BoxBound& box,
                             std::uint32_t ends, std::uint32_t own, float z_m, RayBounds& rays) {
  if (box.hidden) return View::hidden;
  rays.farthest_m = static_cast<float>(ends >> 16) * f.metres_per_unit;
  if (ends >> 16 == 0 || rays.farthest_m < z_m - view.half_z_m) return View::hidden;
  if (!box.inside) return box.clear && f.window_px_m > 0.0F ? View::look : View::look_at_border;
  const float behind = behind_m(f, z_m, view.half_z_m);
  if (rays.farthest_m <= behind && !is_block) return View::look;
  rays.nearest_m = static_cast<float>(own & 0xFFFFU) * f.metres_per_unit;
  return rays.nearest_m > behind ? View::all_free : View::look;
}

/// Joins the shares of kSharers neighbouring threads.
template <int kSharers, typename Group, int kThreads>
inline G3D_GPU void join_shares(const Group& group, PerThread<std::uint32_t, kThreads>& ends,
                                PerThread<std::uint32_t, kThreads>& own) {
  PerThread<std::uint32_t, kThreads> joined;
#pragma GCC unroll 5
  for (int bits = 1; bits < kSharers; bits *= 2) {
    for (PerThread<std::uint32_t, kThreads>* values : {&ends, &own}) {
      group.lanes([&](int t) { joined[t] = join_ends((*values)[t], values->peer(t, bits)); });
      group.lanes([&](int t) { (*values)[t] = joined[t]; });
    }
  }
}

/// What one thread alone finds out about a box. It looks at the own pixels only where they are of account.
inline G3D_GPU View decide_alone(const FrameParams& f, const Memory& m, const TopLevels& top, const cpu::BoxView& view,
                                 bool is_block, const BoxBound& box, float z_m, RayBounds& rays) {
  if (box.hidden) return View::hidden;
  const std::uint32_t ends = gather_ends<1>(cells_of(f, m, top, box.u0, box.v0, box.u1, box.v1), 0);
  const float farthest_m = static_cast<float>(ends >> 16) * f.metres_per_unit;
  const bool reaches = ends >> 16 != 0 && farthest_m >= z_m - view.half_z_m;
  std::uint32_t own = 0;
  if (reaches && box.inside && (is_block || farthest_m > behind_m(f, z_m, view.half_z_m))) {
    own = gather_ends<1>(cells_of(f, m, top, box.centre_u0, box.centre_v0, box.centre_u1, box.centre_v1), 0);
  }
  return conclude(f, view, is_block, box, ends, own, z_m, rays);
}

/// One of a block's eight bricks; see cpu::VisibleBlocks::classify_bricks. `block`: what is known of the block's rays.
inline G3D_GPU View decide_brick(const FrameParams& f, const Memory& m, const TopLevels& top, const Corner& corner,
                                 const RayBounds& block, int brick) {
  const float z_m = corner.z_m + f.brick_middle_m[2][brick];
  const float half_z_m = f.brick_view.half_z_m;
  if (block.farthest_m < z_m - half_z_m) return View::hidden;
  if (block.nearest_m > behind_m(f, z_m, half_z_m)) return View::all_free;
  const BoxBound box =
      bound_box(f.brick_view, corner.x_m + f.brick_middle_m[0][brick], corner.y_m + f.brick_middle_m[1][brick], z_m);
  RayBounds rays;
  return decide_alone(f, m, top, f.brick_view, false, box, z_m, rays);
}

/// Block i (x fastest) of a group of 4x4x4 whose first voxel lies at `first`.
inline G3D_GPU View decide_block(const FrameParams& f, const Memory& m, const TopLevels& top, const Corner& first,
                                 int i, RayBounds& rays) {
  const FrameTables& tables = m.input->tables;
  const float z_m = first.z_m + tables.block_middle_m[2][i];
  const BoxBound box =
      bound_box(f.block_view, first.x_m + tables.block_middle_m[0][i], first.y_m + tables.block_middle_m[1][i], z_m);
  return decide_alone(f, m, top, f.block_view, true, box, z_m, rays);
}

}  // namespace g3d::mapper::cuda
