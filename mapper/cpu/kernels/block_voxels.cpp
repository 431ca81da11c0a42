// SPDX-License-Identifier: Apache-2.0
// Loops over the voxels of one block: which of them the camera saw through, and how their levels change.
#include <algorithm>
#include <cstring>

#include "mapper/cpu/kernels/variant.hpp"

namespace g3d::mapper::cpu::G3D_KERNEL_VARIANT {

void bound_boxes(const BoxView& view, int count, BoxBounds& boxes) {
  const BoxView b = view;
  for (int i = 0; i < count; ++i) {
    const float z_low = boxes.z_m[i] - b.half_z_m;
    const float z_high = boxes.z_m[i] + b.half_z_m;
    const bool projects = z_low > b.near_plane_m;
    const float inverse_low = 1.0F / (projects ? z_low : 1.0F);
    const float inverse_high = 1.0F / (projects ? z_high : 1.0F);
    // A window of w pixels has a side of at most 1.13 w after rounding to cells of at most 0.27 w, and its middle is
    // off by half a cell: 0.7 w to each side. Across the image's border the voxel's own silhouette counts as well.
    const float window_px = b.window_px_m * inverse_low;
    const float near_px = 0.7F * window_px + 1.5F;
    const float reach_px = 1.5F * window_px + 2.0F;
    const float x_low = boxes.x_m[i] - b.half_x_m;
    const float x_high = boxes.x_m[i] + b.half_x_m;
    const float y_low = boxes.y_m[i] - b.half_y_m;
    const float y_high = boxes.y_m[i] + b.half_y_m;
    const float left = b.fx_px * x_low * (x_low < 0 ? inverse_low : inverse_high) + b.cx_px;
    const float right = b.fx_px * x_high * (x_high > 0 ? inverse_low : inverse_high) + b.cx_px;
    const float top = b.fy_px * y_low * (y_low < 0 ? inverse_low : inverse_high) + b.cy_px;
    const float bottom = b.fy_px * y_high * (y_high > 0 ? inverse_low : inverse_high) + b.cy_px;
    const float x_px_m = b.fx_px * boxes.x_m[i];
    const float y_px_m = b.fy_px * boxes.y_m[i];
    const float from_left = x_px_m - b.left_px * boxes.z_m[i];
    const float from_right = b.right_px * boxes.z_m[i] - x_px_m;
    const float from_top = y_px_m - b.top_px * boxes.z_m[i];
    const float from_bottom = b.bottom_px * boxes.z_m[i] - y_px_m;
    const bool beside = (from_left < -b.outer_px_m[0]) | (from_right < -b.outer_px_m[1]) |
                        (from_top < -b.outer_px_m[2]) | (from_bottom < -b.outer_px_m[3]);
    boxes.clear[i] = (from_left >= b.inner_px_m[0]) & (from_right >= b.inner_px_m[1]) & (from_top >= b.inner_px_m[2]) &
                             (from_bottom >= b.inner_px_m[3])
                         ? 1
                         : 0;
    const bool within = (left >= 0.0F) & (right <= b.last_u_px) & (top >= 0.0F) & (bottom <= b.last_v_px);
    boxes.hidden[i] = (z_high <= 0.0F) | (z_low > b.far_m) | beside ? 1 : 0;
    boxes.inside[i] = projects & within ? 1 : 0;
    const float around_px = within ? near_px : reach_px;
    const float u0 = std::min(std::max(left - around_px, 0.0F), b.last_u_px);
    const float v0 = std::min(std::max(top - around_px, 0.0F), b.last_v_px);
    const float u1 = std::min(std::max(right + around_px, 0.0F), b.last_u_px);
    const float v1 = std::min(std::max(bottom + around_px, 0.0F), b.last_v_px);
    const bool whole = projects & within;
    boxes.centre_u0[i] = static_cast<std::int32_t>(whole ? left : 0.0F);
    boxes.centre_v0[i] = static_cast<std::int32_t>(whole ? top : 0.0F);
    boxes.centre_u1[i] = static_cast<std::int32_t>(whole ? std::min(right + 1.0F, b.last_u_px) : b.last_u_px);
    boxes.centre_v1[i] = static_cast<std::int32_t>(whole ? std::min(bottom + 1.0F, b.last_v_px) : b.last_v_px);
    boxes.u0[i] = static_cast<std::int32_t>(projects ? u0 : 0.0F);
    boxes.v0[i] = static_cast<std::int32_t>(projects ? v0 : 0.0F);
    boxes.u1[i] = static_cast<std::int32_t>(projects ? u1 : b.last_u_px);
    boxes.v1[i] = static_cast<std::int32_t>(projects ? v1 : b.last_v_px);
  }
}

bool project_brick(const ProjectBrick& b, std::uint8_t* free) {
  const int first = b.first_place;
  const float* __restrict ox = b.tables->x_px_m + first;
  const float* __restrict oy = b.tables->y_px_m + first;
  const float* __restrict oz = b.tables->z_units + first;
  alignas(64) std::int32_t cell[64];
  alignas(64) float depth_units[64];
  const ProjectBrick p = b;
  for (int i = 0; i < 64; ++i) {
    const float z_units = p.z_units + oz[i];
    const float z_m = std::max(z_units, p.min_z_units) * p.metres_per_unit;
    const float inverse = p.scale / z_m;
    const float x = std::min(std::max((p.x_px_m + ox[i]) * inverse + p.shift_x, p.first_x), p.last_x);
    const float y = std::min(std::max((p.y_px_m + oy[i]) * inverse + p.shift_y, p.first_y), p.last_y);
    cell[i] = static_cast<std::int32_t>(y) * p.stride + static_cast<std::int32_t>(x);
    depth_units[i] = z_units;
  }
  alignas(64) std::uint16_t seen[64];
#pragma GCC unroll 16
  for (int i = 0; i < 64; ++i) seen[i] = p.image[cell[i]];
  std::uint8_t* __restrict out = free + first;
  std::int32_t any = 0;
  alignas(64) std::int32_t flag[64];
  for (int i = 0; i < 64; ++i) {
    const float z_units = depth_units[i];
    const float beyond = z_units + p.bias_units;
    const float needed = z_units + p.far_bias_units <= p.far_units ? std::min(beyond, p.far_units) : beyond;
    const bool through = (static_cast<float>(seen[i]) >= needed) & (z_units >= p.min_z_units);
    flag[i] = through ? kWeakFree : 0;
  }
  if (p.at_border) {
    for (int i = 0; i < 64; ++i) {
      const float z_m = depth_units[i] * p.metres_per_unit;
      const float x = p.x_px_m + ox[i];
      const float y = p.y_px_m + oy[i];
      const bool inside = (x + p.reach_px_m[0] >= p.left_px * z_m) & (x - p.reach_px_m[1] <= p.right_px * z_m) &
                          (y + p.reach_px_m[2] >= p.top_px * z_m) & (y - p.reach_px_m[3] <= p.bottom_px * z_m);
      flag[i] = inside ? flag[i] : 0;
    }
  }
  for (int i = 0; i < 64; ++i) any |= flag[i];
  for (int i = 0; i < 64; ++i) out[i] = static_cast<std::uint8_t>(flag[i]);
  return any != 0;
}

ApplyResult apply_block(const ApplyBlock& block) {
  std::uint8_t* __restrict levels = block.levels;
  static constexpr std::uint8_t kNothing[512] = {};
  const std::uint8_t* __restrict hits = block.hits != nullptr ? block.hits : kNothing;
  const std::uint8_t* __restrict free = block.free != nullptr ? block.free : kNothing;
  const std::uint8_t hit_step = block.steps.hit;
  const std::uint8_t miss_step = block.steps.miss;
  std::uint8_t differs = 0;
  std::uint8_t all_or = 0;
  std::uint8_t all_and = 0xFF;
  std::uint8_t lost_bricks = 0;
  for (int brick = 0; brick < 8; ++brick) {
    std::uint8_t lost = 0;
    for (int i = 64 * brick; i < 64 * brick + 64; ++i) {
      const std::uint8_t old_byte = levels[i];
      const std::uint8_t level = old_byte & kLevelMask;
      const std::uint8_t raised = std::min<std::uint8_t>(static_cast<std::uint8_t>(level + hit_step), kMaxLevel);
      const std::uint8_t after_a_hit = raised == kUnknownLevel ? kUnknownLevel + 1 : raised;
      const std::uint8_t lowered = static_cast<std::uint8_t>(level - std::min(level, miss_step));
      const std::uint8_t after_a_miss = lowered == kUnknownLevel ? kUnknownLevel - 1 : lowered;
      // A pixel without a reading never wears down what was measured: it may be blind because something is too near.
      // Nor does a ray past the outline of what is too near: the voxel is held.
      const bool passed = (free[i] == kStrongFree) | ((free[i] != 0) & (level <= kUnknownLevel));
      const bool is_free = passed & (hits[i] == 0);
      const std::uint8_t moved = is_free ? after_a_miss : level;
      const std::uint8_t next = (hits[i] & kHitFlag) != 0 ? after_a_hit : moved;
      const std::uint8_t colour = next > kUnknownLevel ? old_byte & kHasColourBit : 0;
      const std::uint8_t new_byte = next | colour;
      differs |= static_cast<std::uint8_t>(new_byte ^ old_byte);
      lost |= static_cast<std::uint8_t>((old_byte & kHasColourBit) ^ colour);
      all_or |= new_byte;
      all_and &= new_byte;
      levels[i] = new_byte;
    }
    if (lost != 0) lost_bricks = static_cast<std::uint8_t>(lost_bricks | (1U << brick));
  }
  return {differs != 0, all_or == all_and, lost_bricks};
}

bool any_contested(const std::uint8_t* levels, const std::uint8_t* hits, const std::uint8_t* free) {
  std::uint8_t any = 0;
  for (int i = 0; i < 512; ++i) {
    const bool occupied = (levels[i] & kLevelMask) > kUnknownLevel;
    any |= static_cast<std::uint8_t>(occupied & (free[i] == kWeakFree) & (hits[i] == 0));
  }
  return any != 0;
}

const Kernels& table() {
#define G3D_TEXT_OF(name) #name
#define G3D_TEXT(name) G3D_TEXT_OF(name)
  static constexpr Kernels kTable{G3D_TEXT(G3D_KERNEL_VARIANT),
                                  classify_row,
                                  carry_down,
                                  bound_up,
                                  unproject_row,
                                  drop_repeats,
                                  max_filter_row,
                                  halve_max_row,
                                  halve_min_row,
                                  bound_boxes,
                                  project_brick,
                                  apply_block,
                                  any_contested,
                                  sort_brick,
                                  find_ray,
                                  walk_rays,
                                  walk_bresenham};
  return kTable;
}

}  // namespace g3d::mapper::cpu::G3D_KERNEL_VARIANT
