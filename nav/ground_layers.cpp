// SPDX-License-Identifier: Apache-2.0
#include "nav/ground_layers.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr double kLeastFloorDepth_m = 0.02;  // depth noise on the floor, as height
constexpr double kWantedCell_m = 0.05;
constexpr std::int32_t kGround_layer = mapper::kAxisCells / 2;  // its underside is z = 0

// Layers above z = 0. A hair's breadth of tolerance: 0.05F is not 0.05.
std::int32_t rounded_up(double height_m, double r_m) {
  return kGround_layer + static_cast<std::int32_t>(std::ceil(height_m / r_m - 1e-3));
}
std::int32_t rounded_down(double height_m, double r_m) {
  return kGround_layer + static_cast<std::int32_t>(std::floor(height_m / r_m + 1e-3));
}

}  // namespace

GroundLayers ground_layers(const mapper::Grid& grid, const GroundHeights& heights) {
  const double r_m = static_cast<double>(grid.resolution_m);
  GroundLayers layers;
  layers.band = {rounded_up(heights.step_m, r_m), rounded_up(heights.body_height_m, r_m) - 1};
  layers.floor = {rounded_up(-std::max(r_m, kLeastFloorDepth_m), r_m), layers.band.first - 1};
  layers.air = {layers.band.first, std::min(layers.band.last, rounded_down(heights.presume_below_m, r_m) - 1)};
  layers.low = {layers.air.first, std::max(layers.air.first, rounded_down(heights.low_m, r_m) - 1)};
  layers.drop = {rounded_up(-heights.drop_depth_m, r_m), rounded_down(-std::max(heights.drop_m, r_m), r_m) - 1};
  layers.drop.last = std::min(layers.drop.last, layers.floor.first - 1);
  return layers;
}

int voxels_per_ground_cell(const mapper::Grid& grid) {
  const auto miss_m = [&](int voxels) {
    return std::abs(voxels * static_cast<double>(grid.resolution_m) - kWantedCell_m);
  };
  int best = 1;
  for (const int voxels : {2, 4, 8}) {
    if (miss_m(voxels) < miss_m(best)) best = voxels;
  }
  return best;
}

}  // namespace g3d::nav
