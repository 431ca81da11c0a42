// SPDX-License-Identifier: Apache-2.0
#include "nav/low_view.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr double kBeyondFloor_m = 0.25;  // the floor is seen in the map a little after the camera has it in view
constexpr double kMost_m = 3.0;

}  // namespace

LowView::LowView(const CellGrid<CellState>& like, const LowViewConfig& config)
    : config_(config),
      low_m_(std::clamp((config.height_m - config.hidden_m) / std::tan(config.down_rad), 0.1, kMost_m)),
      far_m_(std::clamp(config.height_m / std::tan(config.down_rad) + kBeyondFloor_m, low_m_, kMost_m)),
      seen_(like.resolution_m, like.origin_x_m, like.origin_y_m, like.columns, like.rows, 0) {}

void LowView::look(const CellGrid<CellState>& states, const hal::PlanarPose& pose, const DepthScan* scan) {
  if (scan != nullptr) {
    for (const DepthScan::Ray& ray : scan->rays()) {
      if (std::fabs(ray.bearing_rad) > 0.5 * config_.view_rad) continue;
      walk(states, pose, ray.bearing_rad, std::min(far_m_, ray.floor_to_m));
    }
    return;
  }
  const int rays = std::max(2, static_cast<int>(std::ceil(config_.view_rad * far_m_ / (0.6 * states.resolution_m))));
  for (int ray = 0; ray < rays; ++ray) {
    walk(states, pose, config_.view_rad * (static_cast<double>(ray) / (rays - 1) - 0.5), far_m_);
  }
}

void LowView::walk(const CellGrid<CellState>& states, const hal::PlanarPose& pose, double bearing_rad, double reach_m) {
  const double step_m = 0.6 * states.resolution_m;
  const int steps = static_cast<int>(reach_m / step_m);
  const double eye_x_m = pose.x_m + config_.forward_m * std::cos(pose.heading_rad);
  const double eye_y_m = pose.y_m + config_.forward_m * std::sin(pose.heading_rad);
  const double dx_m = step_m * std::cos(pose.heading_rad + bearing_rad);
  const double dy_m = step_m * std::sin(pose.heading_rad + bearing_rad);
  for (int i = 1; i <= steps; ++i) {
    const Cell c = states.cell_of(eye_x_m + i * dx_m, eye_y_m + i * dy_m);
    if (!states.contains(c) || states.at(c) != CellState::free) break;
    if (i * step_m >= low_m_) seen_.at(c) = 1;
  }
}

}  // namespace g3d::nav
