// SPDX-License-Identifier: Apache-2.0
#include "nav/depth_scan.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr double kOneThing_m = 0.1;    // two readings so near each other confirm one another
constexpr double kBelowFloor_m = 0.1;  // lower is no floor any more
constexpr int kGap_rows = 2;           // without a reading: chance

/// The nearest readings of a column, in order.
class Nearest {
 public:
  struct Point {
    double distance_m = 1e9;
    double x_m = 0.0;
    double y_m = 0.0;
  };

  void add(const Point& point) {
    std::size_t i = points_.size();
    while (i > 0 && point.distance_m < points_[i - 1].distance_m) --i;
    if (i == points_.size()) return;
    std::move_backward(points_.begin() + static_cast<std::ptrdiff_t>(i), points_.end() - 1, points_.end());
    points_[i] = point;
  }
  /// The first one that another confirms; nothing if each stands alone.
  [[nodiscard]] const Point* confirmed() const {
    for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
      if (points_[i + 1].distance_m < 1e9 && points_[i + 1].distance_m - points_[i].distance_m < kOneThing_m) {
        return &points_[i];
      }
    }
    return nullptr;
  }

 private:
  std::array<Point, 4> points_;
};

}  // namespace

DepthScan::DepthScan(const DepthScanConfig& config)
    : config_(config), T_base_camera_(hal::to_transform(config.T_base_camera)) {}

DepthScan::Ray DepthScan::scan_column(const hal::Frame& frame, const hal::CameraModel& camera, int u) const {
  const auto& r = T_base_camera_.rotation;
  const float right = (static_cast<float>(u) - camera.cx_px) / camera.fx_px;
  Ray ray;
  ray.bearing_rad = std::atan2(static_cast<double>(r[3] * right + r[5]), static_cast<double>(r[0] * right + r[2]));
  Nearest nearest;
  int missing_rows = 0;  // since the last reading of the floor
  for (int i = kRows - 1; i >= 0; --i) {
    ++missing_rows;
    const int v = (2 * i + 1) * camera.height_px / (2 * kRows);
    const std::uint16_t raw = frame.depth[static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width_px) +
                                          static_cast<std::size_t>(u)];
    const float z_m = static_cast<float>(raw) / camera.depth_units_per_metre;
    if (static_cast<double>(z_m) < config_.near_m) continue;
    const float down = (static_cast<float>(v) - camera.cy_px) / camera.fy_px;
    const double dx_m = static_cast<double>(z_m * (r[0] * right + r[1] * down + r[2]));
    const double dy_m = static_cast<double>(z_m * (r[3] * right + r[4] * down + r[5]));
    const double height_m =
        static_cast<double>(T_base_camera_.translation_m[2] + z_m * (r[6] * right + r[7] * down + r[8]));
    const double distance_m = std::hypot(dx_m, dy_m);
    if (missing_rows <= kGap_rows + 1 && height_m < config_.low_m && height_m > -kBelowFloor_m) {
      ray.floor_to_m = std::max(ray.floor_to_m, distance_m);
      missing_rows = 0;
    }
    if (height_m <= config_.body_height_m) ray.through_m = std::max(ray.through_m, std::min(distance_m, config_.far_m));
    if (height_m < config_.low_m || height_m > config_.body_height_m) continue;
    nearest.add({distance_m, eye_x_m() + dx_m, eye_y_m() + dy_m});
  }
  const Nearest::Point* hit = nearest.confirmed();
  if (hit == nullptr) return ray;
  ray.through_m = std::min(hit->distance_m, config_.far_m);
  ray.has_hit = hit->distance_m <= config_.far_m;
  ray.hit_x_m = hit->x_m;
  ray.hit_y_m = hit->y_m;
  return ray;
}

void DepthScan::look(const hal::Frame& frame, const hal::CameraModel& camera) {
  for (int i = 0; i < kRays; ++i) {
    const int u = (2 * i + 1) * camera.width_px / (2 * kRays);
    rays_[static_cast<std::size_t>(i)] = scan_column(frame, camera, u);
  }
}

}  // namespace g3d::nav
