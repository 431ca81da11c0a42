// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/depth_samples.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::mapper::align {
namespace {

constexpr int kTilesAcross = 160;
// A plane that is seen at a grazing angle changes its disparity by 1 / (distance of the plane * focal length) per
// pixel: 0.004 per metre for a floor 0.5 m below. A step of 3 % of the distance is more than a tile of that.
constexpr float kLargestStepInTile = 0.03F;
// Second difference of disparity over four tiles: zero on a plane.
constexpr float kLargestBend = 0.012F;
constexpr int kNormalReach_tiles = 2;
// Seen flatter than this, a surface is measured too badly.
constexpr float kLeastCosineToRay = 0.17F;
constexpr std::size_t kPlaces = 1U << 14;

// Noise of a Kinect's depth (Nguyen, Izadi and Lovell 2012): sigma = 1.2 mm + 1.9 mm (z - 0.4)^2.
float depth_sigma_m(float z_m) { return 0.0012F + 0.0019F * (z_m - 0.4F) * (z_m - 0.4F); }

std::size_t place(int row, int column, int width) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
}

}  // namespace

std::uint64_t cube_of(const Vector3f& point_m, float side_m) {
  std::uint64_t key = 1;
  for (const float x : point_m) {
    const auto cell = static_cast<std::int32_t>(std::floor(x / side_m));
    key = key << 20 | (static_cast<std::uint64_t>(cell + (1 << 19)) & 0xFFFFFU);
  }
  return key;
}

DepthSamples::DepthSamples(const hal::CameraModel& camera, const SampleOptions& options)
    : camera_(camera),
      options_(options),
      tile_px_(std::max(1, camera.width_px / kTilesAcross)),
      columns_(camera.width_px / tile_px_),
      rows_(camera.height_px / tile_px_),
      inverse_of_raw_(std::size_t{1} << 16),
      inverse_depth_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)),
      samples_(inverse_depth_.size()),
      chosen_(options.most_chosen),
      taken_(kPlaces) {
  const float least_raw = options.near_m * camera.depth_units_per_metre;
  const float most_raw = options.far_m * camera.depth_units_per_metre;
  for (std::size_t raw = 1; raw < inverse_of_raw_.size(); ++raw) {
    const auto r = static_cast<float>(raw);
    if (r >= least_raw && r <= most_raw) inverse_of_raw_[raw] = camera.depth_units_per_metre / r;
  }
  const float half = 0.5F * static_cast<float>(tile_px_ - 1);
  for (int c = 0; c < columns_; ++c) {
    column_slope_.push_back((static_cast<float>(c * tile_px_) + half - camera.cx_px) / camera.fx_px);
  }
  for (int r = 0; r < rows_; ++r) {
    row_slope_.push_back((static_cast<float>(r * tile_px_) + half - camera.cy_px) / camera.fy_px);
  }
}

void DepthSamples::compute(const std::uint16_t* depth) {
  average_tiles(depth);
  find_normals();
  choose();
}

void DepthSamples::average_tiles(const std::uint16_t* depth) {
  const int least_readings = (tile_px_ * tile_px_ + 1) / 2;
  for (int r = 0; r < rows_; ++r) {
    for (int c = 0; c < columns_; ++c) {
      float sum = 0.0F;
      float least = 1e9F;
      float most = 0.0F;
      int readings = 0;
      for (int y = 0; y < tile_px_; ++y) {
        const std::uint16_t* row = depth + place(r * tile_px_ + y, c * tile_px_, camera_.width_px);
        for (int x = 0; x < tile_px_; ++x) {
          const float w = inverse_of_raw_[row[x]];
          sum += w;
          most = std::max(most, w);
          least = w > 0.0F ? std::min(least, w) : least;
          readings += w > 0.0F ? 1 : 0;
        }
      }
      const bool is_whole = readings >= least_readings && most - least <= kLargestStepInTile;
      inverse_depth_[place(r, c, columns_)] = is_whole ? sum / static_cast<float>(readings) : 0.0F;
    }
  }
}

void DepthSamples::find_normals() {
  constexpr int k = kNormalReach_tiles;
  sample_count_ = 0;
  const auto at = [&](int r, int c) { return inverse_depth_[place(r, c, columns_)]; };
  const auto point = [&](int r, int c, float w) {
    const float z = 1.0F / w;
    return Vector3f{column_slope_[static_cast<std::size_t>(c)] * z, row_slope_[static_cast<std::size_t>(r)] * z, z};
  };
  for (int r = k; r < rows_ - k; ++r) {
    for (int c = k; c < columns_ - k; ++c) {
      const float w = at(r, c);
      const float left = at(r, c - k);
      const float right = at(r, c + k);
      const float up = at(r - k, c);
      const float down = at(r + k, c);
      if (w == 0.0F || left == 0.0F || right == 0.0F || up == 0.0F || down == 0.0F) continue;
      if (std::abs(left + right - 2.0F * w) > kLargestBend || std::abs(up + down - 2.0F * w) > kLargestBend) continue;
      const Vector3f p_left = point(r, c - k, left);
      const Vector3f p_right = point(r, c + k, right);
      const Vector3f p_up = point(r - k, c, up);
      const Vector3f p_down = point(r + k, c, down);
      const Vector3f a{p_right[0] - p_left[0], p_right[1] - p_left[1], p_right[2] - p_left[2]};
      const Vector3f b{p_down[0] - p_up[0], p_down[1] - p_up[1], p_down[2] - p_up[2]};
      // y (down) x x (right) looks towards the camera.
      Vector3f n{b[1] * a[2] - b[2] * a[1], b[2] * a[0] - b[0] * a[2], b[0] * a[1] - b[1] * a[0]};
      const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
      if (!(length > 0.0F)) continue;
      for (float& x : n) x /= length;
      const Vector3f p = point(r, c, w);
      const float range = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
      const float cosine = -(n[0] * p[0] + n[1] * p[1] + n[2] * p[2]) / range;
      if (cosine < kLeastCosineToRay) continue;
      // An error in depth moves the point along its ray; only the part along the normal counts.
      const float sigma_m = depth_sigma_m(p[2]) * cosine + 0.001F;
      samples_[sample_count_++] = {p, n, 1e-6F / (sigma_m * sigma_m)};
    }
  }
}

void DepthSamples::choose() {
  std::fill(taken_.begin(), taken_.end(), 0);
  chosen_count_ = 0;
  for (std::size_t i = 0; i < sample_count_ && chosen_count_ < chosen_.size(); ++i) {
    const std::uint64_t key = cube_of(samples_[i].point_m, options_.spacing_m);
    std::size_t at = (key * 0x9E3779B97F4A7C15ULL) >> 50;
    while (taken_[at] != 0 && taken_[at] != key) at = (at + 1) & (kPlaces - 1);
    if (taken_[at] == key) continue;
    taken_[at] = key;
    chosen_[chosen_count_++] = samples_[i];
  }
}

}  // namespace g3d::mapper::align
