// SPDX-License-Identifier: Apache-2.0
#include "nav/path_track.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {

PathTrack::PathTrack(std::size_t max_points) : max_points_(max_points) {
  points_.reserve(max_points);
  at_m_.reserve(max_points);
}

void PathTrack::clear() {
  points_.clear();
  at_m_.clear();
  travelled_m_ = 0.0;
  offset_m_ = 0.0;
}

void PathTrack::set(std::span<const Waypoint> path) {
  clear();
  double length_m = 0.0;
  for (const Waypoint& point : path.first(std::min(path.size(), max_points_))) {
    if (!points_.empty()) {
      const double step_m = std::hypot(point.x_m - points_.back().x_m, point.y_m - points_.back().y_m);
      if (!(step_m > 0.0)) continue;
      length_m += step_m;
    }
    points_.push_back(point);
    at_m_.push_back(length_m);
  }
}

Waypoint PathTrack::at(double along_m) const {
  const auto after = std::upper_bound(at_m_.begin(), at_m_.end(), along_m);
  if (after == at_m_.end()) return points_.back();
  if (after == at_m_.begin()) return points_.front();
  const auto i = static_cast<std::size_t>(after - at_m_.begin());
  const double part = (along_m - at_m_[i - 1]) / (at_m_[i] - at_m_[i - 1]);
  const Waypoint& a = points_[i - 1];
  const Waypoint& b = points_[i];
  return {a.x_m + part * (b.x_m - a.x_m), a.y_m + part * (b.y_m - a.y_m)};
}

Waypoint PathTrack::ahead(double distance_m) const { return at(travelled_m_ + distance_m); }

void PathTrack::advance(double x_m, double y_m) {
  if (points_.empty()) return;
  double best_m = travelled_m_;
  const Waypoint here = at(travelled_m_);
  offset_m_ = std::hypot(here.x_m - x_m, here.y_m - y_m);
  auto i = static_cast<std::size_t>(std::upper_bound(at_m_.begin(), at_m_.end(), travelled_m_) - at_m_.begin());
  for (; i < points_.size() && at_m_[i - 1] <= travelled_m_ + kWindow_m; ++i) {
    const Waypoint& a = points_[i - 1];
    const Waypoint& b = points_[i];
    const double length_m = at_m_[i] - at_m_[i - 1];
    const double dx = (b.x_m - a.x_m) / length_m;
    const double dy = (b.y_m - a.y_m) / length_m;
    const double along = std::clamp((x_m - a.x_m) * dx + (y_m - a.y_m) * dy, 0.0, length_m);
    const double along_m = at_m_[i - 1] + along;
    if (along_m < travelled_m_ || along_m > travelled_m_ + kWindow_m) continue;
    const double offset_m = std::hypot(a.x_m + along * dx - x_m, a.y_m + along * dy - y_m);
    if (offset_m >= offset_m_) continue;
    offset_m_ = offset_m;
    best_m = along_m;
  }
  travelled_m_ = best_m;
}

}  // namespace g3d::nav
