// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/depth_samples.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::mapper::align {
namespace {

constexpr std::size_t kPlaces = 1U << 14;

std::size_t place(int row, int column, int width) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
}

SampleShape shape_of(const hal::CameraModel& camera, const SampleOptions& options) {
  SampleShape shape;
  shape.units_per_metre = camera.depth_units_per_metre;
  shape.least_raw = options.near_m * camera.depth_units_per_metre;
  shape.most_raw = options.far_m * camera.depth_units_per_metre;
  shape.fx_px = camera.fx_px;
  shape.fy_px = camera.fy_px;
  shape.cx_px = camera.cx_px;
  shape.cy_px = camera.cy_px;
  shape.spacing_m = options.spacing_m;
  shape.width_px = camera.width_px;
  shape.tile_px = std::max(1, camera.width_px / kTilesAcross);
  shape.columns = camera.width_px / shape.tile_px;
  shape.rows = camera.height_px / shape.tile_px;
  shape.most_chosen = static_cast<std::int32_t>(options.most_chosen);
  return shape;
}

}  // namespace

DepthSamples::DepthSamples(const hal::CameraModel& camera, const SampleOptions& options)
    : shape_(shape_of(camera, options)),
      inverse_of_raw_(std::size_t{1} << 16),
      inverse_depth_(static_cast<std::size_t>(shape_.columns) * static_cast<std::size_t>(shape_.rows)),
      samples_(inverse_depth_.size()),
      chosen_(options.most_chosen),
      taken_(kPlaces) {
  for (std::size_t raw = 0; raw < inverse_of_raw_.size(); ++raw) {
    inverse_of_raw_[raw] = inverse_of(shape_, static_cast<std::uint16_t>(raw));
  }
  for (int c = 0; c < shape_.columns; ++c) column_slope_.push_back(slope_of_column(shape_, c));
  for (int r = 0; r < shape_.rows; ++r) row_slope_.push_back(slope_of_row(shape_, r));
}

void DepthSamples::compute(const std::uint16_t* depth) {
  average_tiles(depth);
  find_normals();
  choose();
}

void DepthSamples::average_tiles(const std::uint16_t* depth) {
  for (int r = 0; r < shape_.rows; ++r) {
    for (int c = 0; c < shape_.columns; ++c) {
      const std::uint16_t* tile = depth + place(r * shape_.tile_px, c * shape_.tile_px, shape_.width_px);
      inverse_depth_[place(r, c, shape_.columns)] = inverse_depth_of_tile(
          shape_.tile_px, [&](int x, int y) { return inverse_of_raw_[tile[place(y, x, shape_.width_px)]]; });
    }
  }
}

void DepthSamples::find_normals() {
  constexpr int k = kNormalReach_tiles;
  sample_count_ = 0;
  const auto at = [&](int r, int c) { return inverse_depth_[place(r, c, shape_.columns)]; };
  const auto x = [&](int c) { return column_slope_[static_cast<std::size_t>(c)]; };
  const auto y = [&](int r) { return row_slope_[static_cast<std::size_t>(r)]; };
  for (int r = k; r < shape_.rows - k; ++r) {
    for (int c = k; c < shape_.columns - k; ++c) {
      const TileCross cross{at(r, c), at(r, c - k), at(r, c + k), at(r - k, c), at(r + k, c), x(c),
                            x(c - k), x(c + k),     y(r),         y(r - k),     y(r + k)};
      if (sample_of(cross, samples_[sample_count_])) ++sample_count_;
    }
  }
}

void DepthSamples::choose() {
  std::fill(taken_.begin(), taken_.end(), 0);
  chosen_count_ = 0;
  for (std::size_t i = 0; i < sample_count_ && chosen_count_ < chosen_.size(); ++i) {
    const std::uint64_t key = cube_of(samples_[i].point_m, shape_.spacing_m);
    std::size_t at = (key * 0x9E3779B97F4A7C15ULL) >> 50;
    while (taken_[at] != 0 && taken_[at] != key) at = (at + 1) & (kPlaces - 1);
    if (taken_[at] == key) continue;
    taken_[at] = key;
    chosen_[chosen_count_++] = samples_[i];
  }
}

}  // namespace g3d::mapper::align
