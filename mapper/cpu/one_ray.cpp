// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/one_ray.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace g3d::mapper::cpu {
namespace {

constexpr float kNever = std::numeric_limits<float>::infinity();
constexpr int kSmallBundle_px = 16;

std::int32_t key_of(float x_cells) { return static_cast<std::int32_t>(std::ceil(x_cells)) + 32767; }

/// When a ray enters the voxel's slab along each axis, and when it leaves it.
struct SlabTimes {
  float enter[3];
  float leave[3];
};

// Steps are made in the order of their parameters, at a tie x before y before z.
bool is_too_late(float enter, int in, float leave, int out) { return in < out ? enter > leave : enter >= leave; }

bool misses(const SlabTimes& times) {
  for (int in = 0; in < 3; ++in) {
    for (int out = 0; out < 3; ++out) {
      if (in != out && is_too_late(times.enter[in], in, times.leave[out], out)) return true;
    }
  }
  return false;
}

struct Bundle {
  int u0;
  int v0;
  int u1;
  int v1;
};

/// Do all rays of the bundle that reach their end at a depth within [least, most] miss the voxel? Each number of a walk
/// is a monotone function of slopes and depth, rounding included: its values at the corners bound it.
bool all_miss(const RaySearch& s, const Bundle& bundle, float least_m, float most_m, const std::int32_t* voxel) {
  SlabTimes bounds;  // earliest entry, latest exit
  for (int axis = 0; axis < 3; ++axis) {
    const float* R = s.rotation + 3 * axis;
    const float part0 = R[1] * s.row_slope[bundle.v0] + R[2];
    const float part1 = R[1] * s.row_slope[bundle.v1] + R[2];
    const float column0 = s.column_slope[bundle.u0] * R[0];
    const float column1 = s.column_slope[bundle.u1] * R[0];
    const float low = std::min(part0, part1) + std::min(column0, column1);
    const float high = std::max(part0, part1) + std::max(column0, column1);
    const float start = s.translation[axis] / s.resolution_m;
    const float end_low = (std::min(low * least_m, low * most_m) + s.translation[axis]) / s.resolution_m;
    const float end_high = (std::max(high * least_m, high * most_m) + s.translation[axis]) / s.resolution_m;
    const std::int32_t first = key_of(start);
    const std::int32_t apart_low = key_of(end_low) - first;
    const std::int32_t apart_high = key_of(end_high) - first;
    const std::int32_t wanted = voxel[axis] - first;
    if ((wanted > 0 && apart_high <= 0) || (wanted < 0 && apart_low >= 0)) return true;
    const bool rises = wanted > 0 || (wanted == 0 && apart_low > 0);
    const bool falls = wanted < 0 || (wanted == 0 && apart_high < 0);
    bounds.enter[axis] = -kNever;
    bounds.leave[axis] = kNever;
    if (!rises && !falls) continue;
    const float gap = rises ? static_cast<float>(first - 32767) - start : start - static_cast<float>(first - 32768);
    const float shortest = rises ? end_low - start : start - end_high;
    const float longest = rises ? end_high - start : start - end_low;
    const float inverse_low = 1.0F / longest;
    const float inverse_high = shortest > 0.0F ? 1.0F / shortest : kNever;
    float earliest = gap * inverse_low;
    float latest = inverse_high < kNever ? gap * inverse_high : kNever;
    for (std::int32_t step = 0; step < std::abs(wanted); ++step) {
      bounds.enter[axis] = earliest;
      earliest += inverse_low;
      latest += inverse_high;
    }
    bounds.leave[axis] = latest;
  }
  return misses(bounds);
}

struct NearSearch {
  const RaySearch& s;
  const std::int32_t* voxel;
  bool strong;
  float least_m;
  float most_m;

  [[nodiscard]] std::uint16_t end_at(int u, int v) const {
    return strong && s.depth[v * s.width_px + u] == 0 ? std::uint16_t{0} : s.ends[v * s.ends_stride + u];
  }

  // As deep as the image has binary digits.
  [[nodiscard]] bool any_passes(const Bundle& bundle) const {
    if (all_miss(s, bundle, least_m, most_m, voxel)) return false;
    const int width = bundle.u1 - bundle.u0 + 1;
    const int height = bundle.v1 - bundle.v0 + 1;
    if (width * height <= kSmallBundle_px) {
      for (int v = bundle.v0; v <= bundle.v1; ++v) {
        for (int u = bundle.u0; u <= bundle.u1; ++u) {
          if (walk_passes(s, u, v, end_at(u, v), voxel)) return true;
        }
      }
      return false;
    }
    Bundle one = bundle;
    Bundle other = bundle;
    if (width >= height) {
      one.u1 = bundle.u0 + width / 2 - 1;
      other.u0 = one.u1 + 1;
    } else {
      one.v1 = bundle.v0 + height / 2 - 1;
      other.v0 = one.v1 + 1;
    }
    return any_passes(one) || any_passes(other);
  }
};

}  // namespace

float walk_error_cells(const SensorGeometry& sensor, const FrameGeometry& frame) {
  const int side_blocks = std::max(frame.nx_blocks, std::max(frame.ny_blocks, frame.nz_blocks));
  float coordinate_m = 0.0F;
  for (const float t : frame.translation_m) coordinate_m = std::max(coordinate_m, std::abs(t));
  return walk_error_cells(static_cast<float>(8 * side_blocks), coordinate_m / sensor.resolution_m);
}

RaySearch ray_search(const SensorGeometry& sensor, const FrameGeometry& frame, const RayEnds& ends,
                     const float* column_slope) {
  RaySearch s{};
  const hal::CameraModel& camera = sensor.camera;
  const auto& R = frame.rotation;
  s.ends = ends.padded() + kImagePadding * ends.stride() + kImagePadding;
  s.ends_stride = ends.stride();
  s.least_end = ends.least_end();
  s.most_end = sensor.far_raw;
  s.depth = ends.depth();
  s.width_px = camera.width_px;
  s.height_px = camera.height_px;
  s.column_slope = column_slope;
  s.row_slope = sensor.row_slope.data();
  s.fx_px = camera.fx_px;
  s.fy_px = camera.fy_px;
  s.cx_px = camera.cx_px;
  s.cy_px = camera.cy_px;
  s.metres_per_unit = sensor.metres_per_unit;
  s.resolution_m = sensor.resolution_m;
  std::copy(R.begin(), R.end(), s.rotation);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    s.translation[axis] = frame.translation_m[axis];
    s.start[axis] = s.translation[axis] / s.resolution_m;
    s.most_coordinate = std::max(s.most_coordinate, std::abs(s.start[axis]));
  }
  s.cells_per_unit = s.metres_per_unit / s.resolution_m;
  s.units_per_cell = 1.0F / s.cells_per_unit;
  s.half_z = 0.5F * (std::abs(R[2]) + std::abs(R[5]) + std::abs(R[8]));
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const float a = (corner & 1) != 0 ? 0.5F : -0.5F;
    const float b = (corner & 2) != 0 ? 0.5F : -0.5F;
    const float c = (corner & 4) != 0 ? 0.5F : -0.5F;
    s.corner_x[corner] = R[0] * a + R[3] * b + R[6] * c;
    s.corner_y[corner] = R[1] * a + R[4] * b + R[7] * c;
    s.corner_z[corner] = R[2] * a + R[5] * b + R[8] * c;
  }
  return s;
}

bool walk_passes(const RaySearch& s, int u, int v, std::uint16_t end_raw, const std::int32_t* voxel) {
  if (end_raw == 0) return false;
  const float z_m = static_cast<float>(end_raw) * s.metres_per_unit;
  SlabTimes times;
  std::int32_t steps_left = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float row_part = s.rotation[3 * axis + 1] * s.row_slope[v] + s.rotation[3 * axis + 2];
    const float p = (row_part + s.column_slope[u] * s.rotation[3 * axis]) * z_m + s.translation[axis];
    const float end = p / s.resolution_m;
    const float start = s.translation[axis] / s.resolution_m;
    const std::int32_t first = key_of(start);
    const std::int32_t apart = key_of(end) - first;
    const std::int32_t before = apart < 0 ? first - voxel[axis] : voxel[axis] - first;
    if (before < 0 || (apart == 0 && before != 0)) return false;
    times.enter[axis] = -kNever;
    times.leave[axis] = kNever;
    steps_left += std::abs(apart) - before;
    if (apart == 0) continue;
    const float inverse = 1.0F / std::abs(end - start);
    const float gap = apart > 0 ? static_cast<float>(first - 32767) - start : start - static_cast<float>(first - 32768);
    float next = gap * inverse;
    for (std::int32_t step = 0; step < before; ++step) {
      times.enter[axis] = next;
      next += inverse;
    }
    times.leave[axis] = next;
  }
  return steps_left > 0 && !misses(times);
}

bool any_walk_passes(const RaySearch& s, const std::int32_t* voxel, bool strong) {
  const NearSearch search{s, voxel, strong, static_cast<float>(s.least_end) * s.metres_per_unit,
                          static_cast<float>(s.most_end) * s.metres_per_unit};
  return search.any_passes({0, 0, s.width_px - 1, s.height_px - 1});
}

}  // namespace g3d::mapper::cpu
