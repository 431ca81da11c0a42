// SPDX-License-Identifier: Apache-2.0
// Voxels that look for rays, where rays used to look for voxels: what most voxels need is one pixel's end; the others
// try all pixels in their silhouette, a vector at a time, by separating axes. Those tests leave a band as wide as the
// rounding errors of a walk; only for rays within it the walk itself is asked.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "mapper/cpu/kernels/variant.hpp"
#include "mapper/cpu/one_ray.hpp"

namespace g3d::mapper::cpu::G3D_KERNEL_VARIANT {

bool sort_brick(const SortBrick& brick, std::uint8_t* sorted) {
  const SortBrick b = brick;
  const float* __restrict ox = b.tables->x_px_m + b.first_place;
  const float* __restrict oy = b.tables->y_px_m + b.first_place;
  const float* __restrict oz = b.tables->z_units + b.first_place;
  alignas(64) std::int32_t own[64];
  alignas(64) std::int32_t around[64];
  alignas(64) std::int32_t state[64];  // 1: in front of the camera and within the image, 2: touches the view
  alignas(64) float depth_units[64];
  for (int i = 0; i < 64; ++i) {
    const float z_units = b.z_units + oz[i];
    const float inverse = 1.0F / (std::max(z_units, 1.0F) * b.metres_per_unit);
    const float x = b.x_px_m + ox[i];
    const float y = b.y_px_m + oy[i];
    const float px = x * inverse;
    const float py = y * inverse;
    const float u = px + b.middle_x;
    const float v = py + b.middle_y;
    const bool inside = (u >= b.first_px) & (u < b.end_x) & (v >= b.first_px) & (v < b.end_y) & (z_units >= 1.0F);
    own[i] = inside ? static_cast<std::int32_t>(v) * b.ends_stride + static_cast<std::int32_t>(u) : 0;
    const float wx = std::min(std::max(px * b.scale + b.shift_x, b.first_cell), b.last_x);
    const float wy = std::min(std::max(py * b.scale + b.shift_y, b.first_cell), b.last_y);
    around[i] = static_cast<std::int32_t>(wy) * b.farthest_stride + static_cast<std::int32_t>(wx);
    const float z_m = z_units * b.metres_per_unit;
    const bool touches = (x + b.reach_px_m[0] >= b.left_px * z_m) & (x - b.reach_px_m[1] <= b.right_px * z_m) &
                         (y + b.reach_px_m[2] >= b.top_px * z_m) & (y - b.reach_px_m[3] <= b.bottom_px * z_m);
    state[i] = (inside & (z_units <= b.sure_units) ? 1 : 0) | (touches ? 2 : 0);
    depth_units[i] = z_units;
  }
  alignas(64) std::uint16_t own_end[64];
  alignas(64) std::uint16_t farthest[64];
#pragma GCC unroll 16
  for (int i = 0; i < 64; ++i) own_end[i] = b.ends[own[i]];
  if (b.farthest != nullptr) {
#pragma GCC unroll 16
    for (int i = 0; i < 64; ++i) farthest[i] = b.farthest[around[i]];
  } else {
    std::memset(farthest, 0xFF, sizeof farthest);
  }
  std::int32_t any = 0;
  for (int i = 0; i < 64; ++i) {
    const bool passed = ((state[i] & 1) != 0) & (static_cast<float>(own_end[i]) > depth_units[i] + b.half_z_units);
    const bool reached = ((state[i] & 2) != 0) & (static_cast<float>(farthest[i]) >= depth_units[i] - b.half_z_units);
    const std::int32_t found = passed ? kPassed : (reached ? kOpen : 0);
    any |= found;
    state[i] = found;
  }
  for (int i = 0; i < 64; ++i) sorted[i] = static_cast<std::uint8_t>(state[i]);
  return any != 0;
}

namespace {

constexpr int kLanes = kVectorBytes / 4;
using Floats = float __attribute__((vector_size(kVectorBytes)));
using Ints = std::int32_t __attribute__((vector_size(kVectorBytes)));
using Shorts = std::uint16_t __attribute__((vector_size(kVectorBytes / 2)));

template <typename Vector>
inline void count_lanes(Vector& lane_number) {
  for (int i = 0; i < static_cast<int>(sizeof lane_number / sizeof lane_number[0]); ++i) {
    lane_number[i] = static_cast<std::remove_reference_t<decltype(lane_number[0])>>(i);
  }
}

inline bool any_of(const Ints& mask) {
  using Bytes = signed char __attribute__((vector_size(kLanes)));
  const Bytes bytes = __builtin_convertvector(mask, Bytes);
  std::uint64_t words[2] = {};
  __builtin_memcpy(words, &bytes, sizeof bytes);
  return (words[0] | words[1]) != 0;
}

inline void take_magnitude(Floats& v) {
  Ints bits;
  __builtin_memcpy(&bits, &v, sizeof bits);
  bits &= 0x7FFFFFFF;
  __builtin_memcpy(&v, &bits, sizeof bits);
}

/// Pixels whose rays may touch a voxel, ends included.
struct PixelBox {
  int u0;
  int v0;
  int u1;
  int v1;
};

/// A voxel as the rays see it.
struct Target {
  const std::int32_t* voxel;
  float c[3];  ///< its centre seen from the camera, in voxels along the world's axes
  float x;     ///< the same along the camera's axes
  float y;
  float z;
  float error;         ///< no rounding carries a walk farther, in voxels
  std::int32_t least;  ///< rays that end nearer do not reach it
};

constexpr float kNearest_cells = 0.05F;  // nearer voxels are not projected: they may cover the whole image

inline PixelBox box_around(const RaySearch& s, const Target& t) {
  using Eight = float __attribute__((vector_size(32)));
  Eight cx;
  Eight cy;
  Eight cz;
  __builtin_memcpy(&cx, s.corner_x, sizeof cx);
  __builtin_memcpy(&cy, s.corner_y, sizeof cy);
  __builtin_memcpy(&cz, s.corner_z, sizeof cz);
  const Eight inverse = 1.0F / (cz + t.z);
  const Eight u = (cx + t.x) * s.fx_px * inverse;
  const Eight v = (cy + t.y) * s.fy_px * inverse;
  // Minimum and maximum over the corners: pairs, fours, all.
  const auto largest = [](const Eight& e) {
    Eight m = e;
    Eight turned = __builtin_shufflevector(m, m, 4, 5, 6, 7, 0, 1, 2, 3);
    m = m > turned ? m : turned;
    turned = __builtin_shufflevector(m, m, 2, 3, 0, 1, 6, 7, 4, 5);
    m = m > turned ? m : turned;
    turned = __builtin_shufflevector(m, m, 1, 0, 3, 2, 5, 4, 7, 6);
    m = m > turned ? m : turned;
    return m[0];
  };
  const float low_u = -largest(-u);
  const float high_u = largest(u);
  const float low_v = -largest(-v);
  const float high_v = largest(v);
  const auto last_u = static_cast<float>(s.width_px - 1);
  const auto last_v = static_cast<float>(s.height_px - 1);
  // Rounding, and the band around the voxel within which rays are asked one by one: it is twice as wide at most along
  // the camera's axes, and what lies off the optical axis moves in depth, too.
  const float off_axis_px = std::max(s.fx_px, s.fy_px) + static_cast<float>(std::max(s.width_px, s.height_px));
  const float slack_px = 0.05F + 2.0F * off_axis_px * t.error / (t.z - s.half_z);
  const auto at_least = [](float value, float most) { return std::ceil(std::min(std::max(value, 0.0F), most)); };
  const auto at_most = [](float value, float most) { return std::floor(std::min(std::max(value, -1.0F), most)); };
  return {static_cast<int>(at_least(low_u + s.cx_px - slack_px, last_u + 1.0F)),
          static_cast<int>(at_least(low_v + s.cy_px - slack_px, last_v + 1.0F)),
          static_cast<int>(at_most(high_u + s.cx_px + slack_px, last_u)),
          static_cast<int>(at_most(high_v + s.cy_px + slack_px, last_v))};
}

/// Does any end in the box reach the voxel's depth? All rows at once, so that most hidden voxels are settled by it.
inline bool any_long_enough(const RaySearch& s, const Target& t, const PixelBox& box) {
  constexpr int kColumns = kVectorBytes / 2;
  using Many = std::uint16_t __attribute__((vector_size(kVectorBytes)));
  Many lane_number;
  count_lanes(lane_number);
  Many most{};
  for (int u = box.u0; u <= box.u1; u += kColumns) {
    const std::uint16_t* ends = s.ends + box.v0 * s.ends_stride + u;
    Many of_columns{};
    for (int v = box.v0; v <= box.v1; ++v, ends += s.ends_stride) {
      Many row;
      __builtin_memcpy(&row, ends, sizeof row);
      of_columns = of_columns > row ? of_columns : row;
    }
    const auto left = static_cast<std::uint16_t>(std::min(box.u1 - u, kColumns - 1));
    of_columns = lane_number <= left ? of_columns : Many{};
    most = most > of_columns ? most : of_columns;
  }
  const Many enough = most >= static_cast<std::uint16_t>(t.least);
  std::uint64_t words[kVectorBytes / 8];
  __builtin_memcpy(words, &enough, sizeof words);
  std::uint64_t any = 0;
  for (const std::uint64_t word : words) any |= word;
  return any != 0;
}

// A ray from the camera to its end P touches a cube around c with half side h if no axis separates them: the three
// faces' normals, |c - P / 2| <= |P / 2| + h, and their cross products with the ray's direction d, e.g. |c_y d_z - c_z
// d_y| <= h (|d_y| + |d_z|). It marks the cube unless it ends inside.
inline bool any_passes(const RaySearch& s, const Target& t, bool strong, int v, int u0, int u1) {
  const float* R = s.rotation;
  const float* c = t.c;
  const float error = t.error;
  const std::uint16_t* ends = s.ends + v * s.ends_stride;
  Ints lane_number;
  count_lanes(lane_number);
  float row_part[3];
  for (int axis = 0; axis < 3; ++axis) row_part[axis] = R[3 * axis + 1] * s.row_slope[v] + R[3 * axis + 2];
  for (int u = u0; u <= u1; u += kLanes) {
    Shorts raw;
    __builtin_memcpy(&raw, ends + u, sizeof raw);
    Ints end = __builtin_convertvector(raw, Ints);
    end = lane_number <= u1 - u ? end : Ints{};
    if (strong) {
      for (int lane = 0; lane < kLanes && u + lane <= u1; ++lane) {
        if (s.depth[v * s.width_px + u + lane] == 0) end[lane] = 0;
      }
    }
    const Ints long_enough = end >= t.least;
    if (!any_of(long_enough)) continue;
    Floats slope;
    __builtin_memcpy(&slope, s.column_slope + u, sizeof slope);
    const Floats dx = (row_part[0] + slope * R[0]) * s.cells_per_unit;
    const Floats dy = (row_part[1] + slope * R[3]) * s.cells_per_unit;
    const Floats dz = (row_part[2] + slope * R[6]) * s.cells_per_unit;
    Floats ax = dx;
    Floats ay = dy;
    Floats az = dz;
    take_magnitude(ax);
    take_magnitude(ay);
    take_magnitude(az);
    Floats across_x = c[1] * dz - c[2] * dy;
    Floats across_y = c[2] * dx - c[0] * dz;
    Floats across_z = c[0] * dy - c[1] * dx;
    take_magnitude(across_x);
    take_magnitude(across_y);
    take_magnitude(across_z);
    across_x -= 0.5F * (ay + az);
    across_y -= 0.5F * (ax + az);
    across_z -= 0.5F * (ax + ay);
    Floats beside = across_x > across_y ? across_x : across_y;
    beside = beside > across_z ? beside : across_z;
    const Floats band = error * (ax + ay + az);
    const Ints near_line = long_enough & (beside <= band);
    if (!any_of(near_line)) continue;
    const Floats half_end = 0.5F * __builtin_convertvector(end, Floats);
    Floats mx = c[0] - dx * half_end;
    Floats my = c[1] - dy * half_end;
    Floats mz = c[2] - dz * half_end;
    Floats ex = mx - dx * half_end;
    Floats ey = my - dy * half_end;
    Floats ez = mz - dz * half_end;
    take_magnitude(mx);
    take_magnitude(my);
    take_magnitude(mz);
    take_magnitude(ex);
    take_magnitude(ey);
    take_magnitude(ez);
    mx -= ax * half_end;
    my -= ay * half_end;
    mz -= az * half_end;
    Floats short_of = mx > my ? mx : my;
    short_of = (short_of > mz ? short_of : mz) - 0.5F;
    Floats beyond = ex > ey ? ex : ey;
    beyond = (beyond > ez ? beyond : ez) - 0.5F;
    const Ints passed = near_line & (beside < -band) & (short_of < -error) & (beyond > error);
    if (any_of(passed)) return true;
    const Ints maybe = near_line & (short_of <= error) & (beyond >= -error);
    if (!any_of(maybe)) continue;
    for (int lane = 0; lane < kLanes; ++lane) {
      if (maybe[lane] != 0 && walk_passes(s, u + lane, v, static_cast<std::uint16_t>(end[lane]), t.voxel)) return true;
    }
  }
  return false;
}

}  // namespace

bool find_ray(const RaySearch& search, const std::int32_t* voxel, bool strong) {
  const RaySearch& s = search;
  Target t;
  t.voxel = voxel;
  float nearness = 0.0F;
  for (int axis = 0; axis < 3; ++axis) {
    t.c[axis] = (static_cast<float>(voxel[axis]) - 32767.5F) - s.start[axis];
    nearness = std::max(nearness, std::abs(t.c[axis]));
  }
  t.error = walk_error_cells(nearness + 1.0F, s.most_coordinate);
  if (nearness <= 0.5F + 2.0F * t.error) return any_walk_passes(s, voxel, strong);
  const float* R = s.rotation;
  t.x = R[0] * t.c[0] + R[3] * t.c[1] + R[6] * t.c[2];
  t.y = R[1] * t.c[0] + R[4] * t.c[1] + R[7] * t.c[2];
  t.z = R[2] * t.c[0] + R[5] * t.c[1] + R[8] * t.c[2];
  const float least = (t.z - s.half_z - 2.0F * t.error) * s.units_per_cell;
  t.least = static_cast<std::int32_t>(std::min(std::max(least, 1.0F), 65535.0F));
  // In the middle a ray is found first.
  const float inverse_z = 1.0F / std::max(t.z, kNearest_cells);
  const float middle_u =
      std::min(std::max(s.fx_px * t.x * inverse_z + s.cx_px, 0.0F), static_cast<float>(s.width_px - 1));
  const float middle_v =
      std::min(std::max(s.fy_px * t.y * inverse_z + s.cy_px, 0.0F), static_cast<float>(s.height_px - 1));
  const int probe_u = std::max(static_cast<int>(middle_u) - kLanes / 2 + 1, 0);
  const int probe_v = static_cast<int>(2.0F * middle_v + 1.0F) / 2;
  if (any_passes(s, t, strong, probe_v, probe_u, std::min(probe_u + kLanes, s.width_px) - 1)) return true;
  PixelBox box{0, 0, s.width_px - 1, s.height_px - 1};
  if (t.z - s.half_z >= kNearest_cells) box = box_around(s, t);
  if (box.u0 > box.u1 || box.v0 > box.v1 || !any_long_enough(s, t, box)) return false;
  for (int v = box.v0; v <= box.v1; ++v) {
    if (any_passes(s, t, strong, v, box.u0, box.u1)) return true;
  }
  return false;
}

}  // namespace g3d::mapper::cpu::G3D_KERNEL_VARIANT
