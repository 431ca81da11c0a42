// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/place_sketch.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace g3d::mapper::submaps {
namespace {

constexpr float kLevelCosine = 0.7F;
constexpr float kLowest_m = -1.0F;  // below the centre, which is where a camera was
constexpr float kHighest_m = 2.0F;

}  // namespace

PlaceSketch::PlaceSketch(std::span<const align::DepthSample> surfaces, const align::Vector3f& centre_m) {
  for (const align::DepthSample& sample : surfaces) {
    if (std::abs(sample.normal[2]) >= kLevelCosine) continue;
    const float x_m = sample.point_m[0] - centre_m[0];
    const float y_m = sample.point_m[1] - centre_m[1];
    const float up_m = sample.point_m[2] - centre_m[2];
    const auto ring = static_cast<int>(std::sqrt(x_m * x_m + y_m * y_m) / kRing_m);
    if (ring >= kRings || up_m < kLowest_m || up_m > kHighest_m) continue;
    const double part = std::atan2(static_cast<double>(y_m), static_cast<double>(x_m)) / (2.0 * std::numbers::pi);
    const auto sector =
        static_cast<std::size_t>(std::clamp(static_cast<int>((part + 0.5) * kSectors), 0, kSectors - 1));
    float& level = columns_[sector][static_cast<std::size_t>(ring)];
    level = std::max(level, 1.0F + std::floor((up_m - kLowest_m) / kLevel_m));
    is_seen_[sector] = true;
  }
  for (Column& column : columns_) {
    float square = 0.0F;
    for (const float level : column) square += level * level;
    if (square == 0.0F) continue;
    const float scale = 1.0F / std::sqrt(square);
    for (float& level : column) level *= scale;
  }
}

PlaceSketch::Likeness PlaceSketch::likeness(const PlaceSketch& other) const {
  Likeness best;
  for (int shift = 0; shift < kSectors; ++shift) {
    int common = 0;
    float sum = 0.0F;
    for (int i = 0; i < kSectors; ++i) {
      const auto here = static_cast<std::size_t>((i + shift) % kSectors);
      const auto there = static_cast<std::size_t>(i);
      if (!is_seen_[here] || !other.is_seen_[there]) continue;
      ++common;
      for (std::size_t ring = 0; ring < kRings; ++ring) sum += columns_[here][ring] * other.columns_[there][ring];
    }
    if (common < kLeastSectors) continue;
    const double share = static_cast<double>(sum) / common;
    if (share <= best.share) continue;
    best.share = share;
    best.turn_rad = 2.0 * std::numbers::pi * shift / kSectors;
  }
  if (best.turn_rad > std::numbers::pi) best.turn_rad -= 2.0 * std::numbers::pi;
  return best;
}

}  // namespace g3d::mapper::submaps
