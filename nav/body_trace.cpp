// SPDX-License-Identifier: Apache-2.0
#include "nav/body_trace.hpp"

#include <algorithm>
#include <cmath>

#include "nav/motion_limits.hpp"

namespace g3d::nav {
namespace {

constexpr double kTouchDepth_m = 0.03;  // an obstacle's centre this far outside of the body
constexpr double kKnownTouch_m = 0.09;  // a cell with its centre this near to the body may be what was touched

template <typename T, typename Visit>
void for_square(const CellGrid<T>& grid, const hal::PlanarPose& pose, double radius_m, Visit visit) {
  const Cell low = grid.cell_of(pose.x_m - radius_m, pose.y_m - radius_m);
  const Cell high = grid.cell_of(pose.x_m + radius_m, pose.y_m + radius_m);
  for (int y = low.y; y <= high.y; ++y) {
    for (int x = low.x; x <= high.x; ++x) {
      const Cell c{x, y};
      if (grid.contains(c)) visit(c, grid.centre_x_m(c) - pose.x_m, grid.centre_y_m(c) - pose.y_m);
    }
  }
}

}  // namespace

BodyTrace::BodyTrace(const CellGrid<CellState>& like, double body_radius_m)
    : body_radius_m_(body_radius_m),
      trodden_(like.resolution_m, like.origin_x_m, like.origin_y_m, like.columns, like.rows, 0) {}

bool BodyTrace::tread(const hal::PlanarPose& pose) {
  if (has_pose_ && std::hypot(pose.x_m - last_pose_.x_m, pose.y_m - last_pose_.y_m) < kTread_m) return false;
  last_pose_ = pose;
  has_pose_ = true;
  for_square(trodden_, pose, body_radius_m_, [this](Cell c, double dx_m, double dy_m) {
    if (dx_m * dx_m + dy_m * dy_m <= body_radius_m_ * body_radius_m_) trodden_.at(c) = 1;
  });
  return true;
}

void BodyTrace::clear() {
  std::fill(trodden_.cells.begin(), trodden_.cells.end(), std::uint8_t{0});
  has_pose_ = false;
}

Waypoint where_touched(const CellGrid<CellState>& states, const hal::PlanarPose& pose, double side_rad,
                       double body_radius_m) {
  const double middle_rad = pose.heading_rad + side_rad;
  double angle_rad = middle_rad;
  double nearest_m = body_radius_m + kKnownTouch_m;
  for_square(states, pose, nearest_m, [&](Cell c, double dx_m, double dy_m) {
    const double distance_m = std::hypot(dx_m, dy_m);
    if (states.at(c) != CellState::occupied || distance_m >= nearest_m) return;
    const double to_rad = std::atan2(dy_m, dx_m);
    if (std::fabs(wrap_angle(to_rad - middle_rad)) > kBumperSide_rad) return;
    nearest_m = distance_m;
    angle_rad = to_rad;
  });
  const double out_m = body_radius_m + kTouchDepth_m;
  return {pose.x_m + out_m * std::cos(angle_rad), pose.y_m + out_m * std::sin(angle_rad)};
}

}  // namespace g3d::nav
