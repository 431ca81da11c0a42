// SPDX-License-Identifier: Apache-2.0
#include "nav/arc_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace g3d::nav {
namespace {

constexpr double kNoDeeper_m = 1e-6;
// A map's noise may put a wall's cells this far into a robot that stands beside it.
constexpr double kOverlap_m = 0.02;

}  // namespace

ArcCheck::ArcCheck(double body_radius_m, double touch_margin_m, double reach_m, double resolution_m)
    : body_radius_m_(body_radius_m), touch_margin_m_(touch_margin_m), reach_m_(reach_m) {
  const double side_cells = 2.0 * std::ceil((reach_m + body_radius_m + kNoticed_m) / resolution_m) + 3.0;
  cells_.reserve(static_cast<std::size_t>(side_cells * side_cells));
}

// An unknown cell is its centre: half a cell of doubt is no reason to stop.
double ArcCheck::distance_m(const NearCell& cell, double x_m, double y_m) const {
  const double half_m = cell.occupied ? half_cell_m_ : 0.0;
  const double dx = std::max(std::fabs(cell.x_m - x_m) - half_m, 0.0);
  const double dy = std::max(std::fabs(cell.y_m - y_m) - half_m, 0.0);
  return std::sqrt(dx * dx + dy * dy);
}

double ArcCheck::distance_m(const NearCell& cell, double x_m, double y_m, bool trusting) const {
  if (!trusting || cell.extent == Extent::square) return distance_m(cell, x_m, y_m);
  if (cell.extent == Extent::nothing) return std::numeric_limits<double>::infinity();
  return std::hypot(cell.x_m - x_m, cell.y_m - y_m);
}

void ArcCheck::gather(const CellGrid<CellState>& ground, const hal::PlanarPose& T_world_base,
                      const FloorKnowledge* floor) {
  cells_.clear();
  half_cell_m_ = 0.5 * ground.resolution_m;
  forward_x_ = std::cos(T_world_base.heading_rad);
  forward_y_ = std::sin(T_world_base.heading_rad);
  clearance_here_m_ = trusted_here_m_ = reach_m_;
  const double radius_m = reach_m_ + body_radius_m_ + kNoticed_m;
  const Cell low = ground.cell_of(T_world_base.x_m - radius_m, T_world_base.y_m - radius_m);
  const Cell high = ground.cell_of(T_world_base.x_m + radius_m, T_world_base.y_m + radius_m);
  for (int y = low.y; y <= high.y; ++y) {
    for (int x = low.x; x <= high.x; ++x) {
      const Cell c{x, y};
      CellState state = ground.contains(c) ? ground.at(c) : CellState::unknown;
      Extent extent = state == CellState::occupied ? Extent::square : Extent::middle;
      if (floor != nullptr && floor->is_suspect(c)) {
        state = CellState::occupied;
        extent = Extent::square;
      } else if (floor != nullptr && state == CellState::occupied) {
        extent = floor->extent(c);
      }
      bool is_unwatched = false;
      if (state == CellState::free && (floor == nullptr || floor->is_seen(c))) {
        is_unwatched = floor != nullptr && floor->is_unwatched(c);
        if (!is_unwatched) continue;
      }
      NearCell cell{ground.centre_x_m(c) - T_world_base.x_m,
                    ground.centre_y_m(c) - T_world_base.y_m,
                    0.0,
                    state == CellState::occupied,
                    extent,
                    is_unwatched};
      cell.start_m = distance_m(cell, 0.0, 0.0);
      if (cell.start_m > radius_m || cells_.size() == cells_.capacity()) continue;
      if (cell.occupied) {
        clearance_here_m_ = std::min(clearance_here_m_, cell.start_m - body_radius_m_);
        trusted_here_m_ = std::min(trusted_here_m_, distance_m(cell, 0.0, 0.0, true) - body_radius_m_);
      }
      cells_.push_back(cell);
    }
  }
}

ArcView ArcCheck::look(double curvature_per_m, double length_m, bool backward, bool trusting) const {
  const double direction = backward ? -1.0 : 1.0;
  const int steps = static_cast<int>(std::ceil(std::min(length_m, reach_m_) / kStep_m));
  const double all_m = steps * kStep_m;
  const double here_m = trusting ? trusted_here_m_ : clearance_here_m_;
  ArcView view{all_m, all_m, false, all_m, std::min(here_m, kNoticed_m)};
  const double turn_rad = 0.5 * direction * kStep_m * curvature_per_m;
  const double turn_cos = std::cos(turn_rad);
  const double turn_sin = std::sin(turn_rad);
  const auto turn = [&](double& x, double& y) {
    const double rotated_x = x * turn_cos - y * turn_sin;
    y = x * turn_sin + y * turn_cos;
    x = rotated_x;
  };
  // Beside a wall that is nearer than the margin the robot may go along it, not deeper.
  const double strict_m =
      body_radius_m_ + std::max(std::min(touch_margin_m_, here_m - kNoDeeper_m), touch_margin_m_ - kSlack_m);
  const double touch_m =
      body_radius_m_ + std::max(std::min(touch_margin_m_ - kSlack_m, here_m - kNoDeeper_m), -kOverlap_m);
  double x_m = 0.0, y_m = 0.0;
  double heading_x = forward_x_, heading_y = forward_y_;
  for (int i = 1; i <= steps; ++i) {
    turn(heading_x, heading_y);  // half before, half after the step: the chord of the arc
    x_m += direction * kStep_m * heading_x;
    y_m += direction * kStep_m * heading_y;
    turn(heading_x, heading_y);
    const double reached_m = (i - 1) * kStep_m;
    for (const NearCell& cell : cells_) {
      if (cell.unwatched) {
        if (view.watched_m <= reached_m) continue;
        const double distance = distance_m(cell, x_m, y_m);
        if (distance < body_radius_m_ && distance < cell.start_m - kNoDeeper_m) view.watched_m = reached_m;
        continue;
      }
      const bool is_free_so_far = view.free_m > reached_m;
      if (!cell.occupied && !is_free_so_far) continue;
      const double distance = distance_m(cell, x_m, y_m, trusting);
      if (cell.occupied) view.clearance_m = std::min(view.clearance_m, distance - body_radius_m_);
      if (distance >= (cell.occupied ? strict_m : body_radius_m_)) continue;
      if (distance >= distance_m(cell, 0.0, 0.0, trusting) - kNoDeeper_m) continue;
      if (is_free_so_far) {
        view.free_m = reached_m;
        view.is_doubtful = !cell.occupied;
      }
      if (!cell.occupied || distance >= touch_m) continue;
      view.clear_m = reached_m;
      return view;
    }
  }
  return view;
}

}  // namespace g3d::nav
