// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/retreat_trail.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::hal::kobuki {

void RetreatTrail::update(const PlanarPose& T_world_base) {
  if (size_ > 0) {
    const double dx_m = T_world_base.x_m - places_[newest_].x_m, dy_m = T_world_base.y_m - places_[newest_].y_m;
    if (dx_m * dx_m + dy_m * dy_m < kSpacing_m * kSpacing_m) return;
  }
  newest_ = (newest_ + 1) % kPlaces;
  places_[newest_] = {T_world_base.x_m, T_world_base.y_m};
  size_ = std::min(size_ + 1, kPlaces);
}

bool RetreatTrail::leads_back_from(const PlanarPose& T_world_base) const {
  const double x_m = T_world_base.x_m - kLookBack_m * std::cos(T_world_base.heading_rad);
  const double y_m = T_world_base.y_m - kLookBack_m * std::sin(T_world_base.heading_rad);
  for (std::size_t i = 0; i < size_; ++i) {
    const Place& place = places_[(newest_ + kPlaces - i) % kPlaces];
    const double dx_m = x_m - place.x_m, dy_m = y_m - place.y_m;
    if (dx_m * dx_m + dy_m * dy_m <= kTolerance_m * kTolerance_m) return true;
  }
  return false;
}

}  // namespace g3d::hal::kobuki
