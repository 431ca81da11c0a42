// SPDX-License-Identifier: Apache-2.0
#include "tests/support/kinematic_robot.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "nav/motion_limits.hpp"

namespace g3d::tests {
namespace {

// Acceleration limits of the reference driver.
constexpr double kFaster_mps2 = 0.5, kSlower_mps2 = 0.6, kTurn_radps2 = 3.5;
constexpr double kHalfView_rad = 0.5 * 57.0 / 57.29577951308232;
constexpr double kNear_m = 0.8, kFar_m = 3.5;
constexpr int kRays = 160;

double approach(double value, double target, double up, double down) {
  const bool is_slowing = std::fabs(target) < std::fabs(value) || target * value < 0.0;
  const double step = is_slowing ? down : up;
  return value + std::clamp(target - value, -step, step);
}

bool is_inside(const std::vector<Box>& boxes, double x_m, double y_m) {
  return std::any_of(boxes.begin(), boxes.end(),
                     [&](const Box& b) { return x_m >= b.x0_m && x_m <= b.x1_m && y_m >= b.y0_m && y_m <= b.y1_m; });
}

}  // namespace

KinematicRobot::KinematicRobot(std::vector<Box> boxes, const hal::PlanarPose& T_world_base, int latency_steps)
    : boxes_(std::move(boxes)), pose_(T_world_base), on_the_way_(static_cast<std::size_t>(latency_steps)) {}

double KinematicRobot::clearance_m() const {
  double nearest_m = 10.0;
  const auto measure = [&](const Box& b) {
    const double dx = std::max({b.x0_m - pose_.x_m, pose_.x_m - b.x1_m, 0.0});
    const double dy = std::max({b.y0_m - pose_.y_m, pose_.y_m - b.y1_m, 0.0});
    nearest_m = std::min(nearest_m, std::sqrt(dx * dx + dy * dy) - kKinematicBody_m);
  };
  std::for_each(boxes_.begin(), boxes_.end(), measure);
  std::for_each(glass_.begin(), glass_.end(), measure);
  return nearest_m;
}

void KinematicRobot::step(const hal::Twist& wanted, double dt_s) {
  on_the_way_.push_back(wanted);
  const hal::Twist command = on_the_way_.front();
  on_the_way_.pop_front();
  if (is_stuck) {
    velocity_ = {};
    return;
  }
  velocity_.forward_mps =
      approach(velocity_.forward_mps, command.forward_mps, kFaster_mps2 * dt_s, kSlower_mps2 * dt_s);
  velocity_.turn_radps = approach(velocity_.turn_radps, command.turn_radps, kTurn_radps2 * dt_s, kTurn_radps2 * dt_s);
  const hal::PlanarPose before = pose_;
  const double clearance_before_m = clearance_m();
  const double middle_rad = pose_.heading_rad + 0.5 * velocity_.turn_radps * dt_s;
  pose_.x_m += velocity_.forward_mps * dt_s * std::cos(middle_rad);
  pose_.y_m += velocity_.forward_mps * dt_s * std::sin(middle_rad);
  pose_.heading_rad = nav::wrap_angle(pose_.heading_rad + velocity_.turn_radps * dt_s);
  rotation_rad_ += std::fabs(velocity_.turn_radps) * dt_s;
  const double now_m = clearance_m();
  const bool touches = now_m < 0.0 && now_m < clearance_before_m;
  if (touches) {
    if (!is_touching_) ++contacts_;
    fastest_contact_mps_ = std::max(fastest_contact_mps_, std::fabs(velocity_.forward_mps));
    pose_.x_m = before.x_m;
    pose_.y_m = before.y_m;
    velocity_.forward_mps = 0.0;
  } else {
    path_m_ += std::fabs(velocity_.forward_mps) * dt_s;
  }
  is_touching_ = touches;
  least_clearance_m_ = std::min(least_clearance_m_, now_m);
}

void KinematicRobot::see(nav::CellGrid<nav::CellState>& ground) const {
  for (int i = 0; i < kRays; ++i) {
    const double angle_rad = pose_.heading_rad + kHalfView_rad * (2.0 * (i + 0.5) / kRays - 1.0);
    const double dx = std::cos(angle_rad), dy = std::sin(angle_rad);
    double hit_m = 0.0;
    while (hit_m < kFar_m && !is_inside(boxes_, pose_.x_m + hit_m * dx, pose_.y_m + hit_m * dy)) hit_m += 0.01;
    if (hit_m < kNear_m) continue;
    for (double s = 0.0; s < hit_m; s += 0.02) {
      const nav::Cell c = ground.cell_of(pose_.x_m + s * dx, pose_.y_m + s * dy);
      if (ground.contains(c) && ground.at(c) == nav::CellState::unknown) ground.at(c) = nav::CellState::free;
    }
    const nav::Cell c = ground.cell_of(pose_.x_m + hit_m * dx, pose_.y_m + hit_m * dy);
    if (hit_m < kFar_m && ground.contains(c)) ground.at(c) = nav::CellState::occupied;
  }
}

nav::CellGrid<nav::CellState> known_floor(const std::vector<Box>& boxes, const Box& extent, double resolution_m) {
  const auto cells = [resolution_m](double length_m) { return static_cast<int>(std::ceil(length_m / resolution_m)); };
  nav::CellGrid<nav::CellState> ground(resolution_m, extent.x0_m, extent.y0_m, cells(extent.x1_m - extent.x0_m),
                                       cells(extent.y1_m - extent.y0_m), nav::CellState::free);
  constexpr double kEdge_m = 1e-9;
  for (const Box& b : boxes) {
    const nav::Cell low = ground.cell_of(b.x0_m + kEdge_m, b.y0_m + kEdge_m);
    const nav::Cell high = ground.cell_of(b.x1_m - kEdge_m, b.y1_m - kEdge_m);
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) {
        if (ground.contains({x, y})) ground.at({x, y}) = nav::CellState::occupied;
      }
    }
  }
  return ground;
}

nav::CellGrid<std::uint8_t> plain_costs(const nav::CellGrid<nav::CellState>& ground, double inscribed_m,
                                        double inflation_m) {
  nav::CellGrid<std::uint8_t> cost(ground.resolution_m, ground.origin_x_m, ground.origin_y_m, ground.columns,
                                   ground.rows, nav::kFreeCost);
  const int reach = static_cast<int>(inflation_m / ground.resolution_m);
  for (std::size_t i = 0; i < ground.cells.size(); ++i) {
    if (ground.cells[i] == nav::CellState::unknown) cost.cells[i] = nav::kUnknownCost;
  }
  for (std::size_t i = 0; i < ground.cells.size(); ++i) {
    if (ground.cells[i] != nav::CellState::occupied) continue;
    const nav::Cell centre = ground.cell(i);
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        const nav::Cell c{centre.x + dx, centre.y + dy};
        const double distance_m = std::sqrt(dx * dx + dy * dy) * ground.resolution_m;
        if (!cost.contains(c) || distance_m > inflation_m) continue;
        int value = static_cast<int>(252.0 * std::exp(-5.0 * (distance_m - inscribed_m)));
        if (distance_m <= inscribed_m) value = nav::kInscribedCost;
        if (dx == 0 && dy == 0) value = nav::kLethalCost;
        const bool is_unknown = cost.at(c) == nav::kUnknownCost;
        if (is_unknown ? value >= nav::kInscribedCost : value > cost.at(c)) {
          cost.at(c) = static_cast<std::uint8_t>(value);
        }
      }
    }
  }
  return cost;
}

}  // namespace g3d::tests
