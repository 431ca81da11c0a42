// SPDX-License-Identifier: Apache-2.0
// An oriented point of a depth image, and how one is made. Inline and without a library's mathematics: the CPU and a
// card run the same lines (see mapper/cuda/kernels.cu). float32, + - * / and sqrt alone, in a fixed order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/geometry.hpp"

namespace g3d::mapper::align {

using Vector3f = std::array<float, 3>;
[[nodiscard]] inline float dot(const Vector3f& a, const Vector3f& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
[[nodiscard]] inline Vector3f rotated(const hal::RigidTransform& T, const Vector3f& v) {
  const auto& m = T.rotation;
  return {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
          m[6] * v[0] + m[7] * v[1] + m[8] * v[2]};
}

[[nodiscard]] inline Vector3f transformed(const hal::RigidTransform& T, const Vector3f& point_m) {
  const Vector3f arm_m = rotated(T, point_m);
  return {arm_m[0] + T.translation_m[0], arm_m[1] + T.translation_m[1], arm_m[2] + T.translation_m[2]};
}

struct DepthSample {
  Vector3f point_m;     ///< camera frame
  Vector3f normal;      ///< unit, towards the camera
  float weight = 0.0F;  ///< (1 mm / sigma)^2 of the point along its normal, 0..1
};

inline constexpr int kTilesAcross = 160;  ///< an image is cut into about so many tiles along its width
inline constexpr int kNormalReach_tiles = 2;

/// What the samples of a camera's images follow from.
struct SampleShape {
  float units_per_metre = 0.0F;  ///< of raw readings
  float least_raw = 0.0F;
  float most_raw = 0.0F;
  float fx_px = 0.0F;
  float fy_px = 0.0F;
  float cx_px = 0.0F;
  float cy_px = 0.0F;
  float spacing_m = 0.0F;  ///< of the chosen samples
  std::int32_t width_px = 0;
  std::int32_t tile_px = 0;
  std::int32_t columns = 0;  ///< tiles
  std::int32_t rows = 0;
  std::int32_t most_chosen = 0;
};

/// 1/m, 0 for none and for what is too near or too far.
[[nodiscard]] inline float inverse_of(const SampleShape& shape, std::uint16_t raw) {
  const auto r = static_cast<float>(raw);
  return raw != 0 && r >= shape.least_raw && r <= shape.most_raw ? shape.units_per_metre / r : 0.0F;
}
/// x / z of the middle of a tile.
[[nodiscard]] inline float slope_of_column(const SampleShape& shape, int column) {
  const float half = 0.5F * static_cast<float>(shape.tile_px - 1);
  return (static_cast<float>(column * shape.tile_px) + half - shape.cx_px) / shape.fx_px;
}
/// y / z
[[nodiscard]] inline float slope_of_row(const SampleShape& shape, int row) {
  const float half = 0.5F * static_cast<float>(shape.tile_px - 1);
  return (static_cast<float>(row * shape.tile_px) + half - shape.cy_px) / shape.fy_px;
}

/// 1/z of a tile: the mean of its readings, 0 if they are few or do not lie on one surface. `inverse_of(x, y)`: 1/z of
/// a pixel of the tile, 0 without a reading.
template <typename InverseOf>
[[nodiscard]] inline float inverse_depth_of_tile(int tile_px, const InverseOf& inverse_of) {
  // A plane that is seen at a grazing angle changes its disparity by 1 / (distance of the plane * focal length) per
  // pixel: 0.004 per metre for a floor 0.5 m below. A step of 3 % of the distance is more than a tile of that.
  constexpr float kLargestStepInTile = 0.03F;
  float sum = 0.0F;
  float least = 1e9F;
  float most = 0.0F;
  int readings = 0;
  for (int y = 0; y < tile_px; ++y) {
    for (int x = 0; x < tile_px; ++x) {
      const float w = inverse_of(x, y);
      sum += w;
      most = most < w ? w : most;
      least = w > 0.0F && w < least ? w : least;
      readings += w > 0.0F ? 1 : 0;
    }
  }
  const bool is_whole = readings >= (tile_px * tile_px + 1) / 2 && most - least <= kLargestStepInTile;
  return is_whole ? sum / static_cast<float>(readings) : 0.0F;
}

/// What four neighbours at kNormalReach_tiles and the tile itself show; `w`s are 1/z, the slopes x / z and y / z of
/// columns and rows. False where there is no surface, an edge or a crease.
struct TileCross {
  float w, left, right, up, down;
  float slope_x, slope_left, slope_right;
  float slope_y, slope_up, slope_down;
};
[[nodiscard]] inline bool sample_of(const TileCross& t, DepthSample& sample) {
  constexpr float kLargestBend = 0.012F;  // second difference of disparity over four tiles: zero on a plane
  // Seen flatter than this, a surface is measured too badly.
  constexpr float kLeastCosineToRay = 0.17F;
  if (t.w == 0.0F || t.left == 0.0F || t.right == 0.0F || t.up == 0.0F || t.down == 0.0F) return false;
  if (__builtin_fabsf(t.left + t.right - 2.0F * t.w) > kLargestBend ||
      __builtin_fabsf(t.up + t.down - 2.0F * t.w) > kLargestBend) {
    return false;
  }
  const float z_left = 1.0F / t.left;
  const float z_right = 1.0F / t.right;
  const float z_up = 1.0F / t.up;
  const float z_down = 1.0F / t.down;
  const Vector3f a{t.slope_right * z_right - t.slope_left * z_left, t.slope_y * z_right - t.slope_y * z_left,
                   z_right - z_left};
  const Vector3f b{t.slope_x * z_down - t.slope_x * z_up, t.slope_down * z_down - t.slope_up * z_up, z_down - z_up};
  // y (down) x x (right) looks towards the camera.
  Vector3f n{b[1] * a[2] - b[2] * a[1], b[2] * a[0] - b[0] * a[2], b[0] * a[1] - b[1] * a[0]};
  const float length = __builtin_sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (!(length > 0.0F)) return false;
  for (std::size_t i = 0; i < 3; ++i) n[i] /= length;
  const float z = 1.0F / t.w;
  const Vector3f p{t.slope_x * z, t.slope_y * z, z};
  const float range = __builtin_sqrtf(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
  const float cosine = -(n[0] * p[0] + n[1] * p[1] + n[2] * p[2]) / range;
  if (cosine < kLeastCosineToRay) return false;
  // Noise of a Kinect's depth (Nguyen, Izadi and Lovell 2012): sigma = 1.2 mm + 1.9 mm (z - 0.4)^2. An error in depth
  // moves the point along its ray; only the part along the normal counts.
  const float depth_sigma_m = 0.0012F + 0.0019F * (z - 0.4F) * (z - 0.4F);
  const float sigma_m = depth_sigma_m * cosine + 0.001F;
  sample = {p, n, 1e-6F / (sigma_m * sigma_m)};
  return true;
}

/// Names the cube of `side_m` that a point lies in; never 0. Points within 500,000 cubes of the origin have their own.
[[nodiscard]] inline std::uint64_t cube_of(const Vector3f& point_m, float side_m) {
  std::uint64_t key = 1;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto cell = static_cast<std::int32_t>(__builtin_floorf(point_m[i] / side_m));
    key = key << 20 | (static_cast<std::uint64_t>(cell + (1 << 19)) & 0xFFFFFU);
  }
  return key;
}

}  // namespace g3d::mapper::align
