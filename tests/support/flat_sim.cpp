// SPDX-License-Identifier: Apache-2.0
#include "tests/support/flat_sim.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::tests {

using nav::Cell;
using nav::CellGrid;
using nav::CellState;

namespace {

constexpr double kInflation_m = 0.45;
constexpr double kInflationDecay_perm = 8.0;

/// costmap_2d's inflation layer.
std::uint8_t inflation_cost(double distance_m) {
  if (distance_m <= 0) return nav::kLethalCost;
  if (distance_m <= kBodyRadius_m) return nav::kInscribedCost;
  return static_cast<std::uint8_t>(252.0 * std::exp(-kInflationDecay_perm * (distance_m - kBodyRadius_m)));
}

}  // namespace

double wrap_angle(double rad) {
  while (rad > 3.141592653589793) rad -= 6.283185307179586;
  while (rad <= -3.141592653589793) rad += 6.283185307179586;
  return rad;
}

CellGrid<std::uint8_t> true_costs(const CellGrid<std::uint8_t>& solid) {
  const CellGrid<float> clearance = clearance_of(solid);
  CellGrid<std::uint8_t> out = solid;
  for (std::size_t i = 0; i < out.cells.size(); ++i) {
    out.cells[i] = clearance.cells[i] > kInflation_m ? nav::kFreeCost : inflation_cost(clearance.cells[i]);
  }
  return out;
}

FlatSim::FlatSim(const FlatWorld& world, const hal::PlanarPose& start, const FlatCamera& camera)
    : world_(world), clearance_(clearance_of(world.solid)), camera_(camera), pose_(start) {
  const auto& s = world.solid;
  ground_ = CellGrid<CellState>(s.resolution_m, s.origin_x_m, s.origin_y_m, s.columns, s.rows, CellState::unknown);
  inflated_ = CellGrid<std::uint8_t>(s.resolution_m, s.origin_x_m, s.origin_y_m, s.columns, s.rows, nav::kFreeCost);
  cost_ = CellGrid<std::uint8_t>(s.resolution_m, s.origin_x_m, s.origin_y_m, s.columns, s.rows, nav::kUnknownCost);
  const int reach = static_cast<int>(kInflation_m / s.resolution_m);
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const double d = std::sqrt(dx * dx + dy * dy) * s.resolution_m;
      if (d <= kInflation_m) stamps_.push_back({dx, dy, inflation_cost(d)});
    }
  }
  const Cell centre = s.cell_of(start.x_m, start.y_m);
  const int body = static_cast<int>(std::ceil(kBodyRadius_m / s.resolution_m));
  for (int dy = -body; dy <= body; ++dy) {
    for (int dx = -body; dx <= body; ++dx) {
      const Cell c{centre.x + dx, centre.y + dy};
      if (std::sqrt(dx * dx + dy * dy) * s.resolution_m > kBodyRadius_m + 0.03 || !s.contains(c) || s.at(c)) continue;
      learn(s.index(c), CellState::free);
    }
  }
  look();
}

void FlatSim::set_observable(const CellGrid<std::uint8_t>* observable) {
  observable_ = observable;
  covered_ = 0;
  observable_total_ = 0;
  for (std::size_t i = 0; i < observable->cells.size(); ++i) {
    if (!observable->cells[i]) continue;
    ++observable_total_;
    covered_ += ground_.cells[i] != CellState::unknown;
  }
}

void FlatSim::learn(std::size_t cell, CellState state) {
  if (ground_.cells[cell] == state) return;
  if (ground_.cells[cell] == CellState::unknown && observable_ != nullptr) covered_ += observable_->cells[cell];
  ground_.cells[cell] = state;
  changed_.push_back(static_cast<std::uint32_t>(cell));
  if (state == CellState::free) {
    cost_.cells[cell] = inflated_.cells[cell];
    return;
  }
  const Cell c = ground_.cell(cell);
  for (const Stamp& stamp : stamps_) {
    const Cell n{c.x + stamp.dx, c.y + stamp.dy};
    if (!ground_.contains(n)) continue;
    const std::size_t i = ground_.index(n);
    if (inflated_.cells[i] >= stamp.cost) continue;
    inflated_.cells[i] = stamp.cost;
    // Inscribed cells are certain contact, known or not, as costmap_2d has it.
    if (ground_.cells[i] == CellState::unknown && stamp.cost < nav::kInscribedCost) continue;
    cost_.cells[i] = stamp.cost;
    changed_.push_back(static_cast<std::uint32_t>(i));
  }
}

void FlatSim::look() {
  const CellGrid<std::uint8_t>& solid = world_.solid;
  for (int k = 0; k < camera_.rays; ++k) {
    const double off = ((k + 0.5) / camera_.rays - 0.5) * camera_.view_rad;
    const double angle = pose_.heading_rad + off;
    const double dx = std::cos(angle);
    const double dy = std::sin(angle);
    const double slant = 1.0 / std::cos(off);
    double hit = 1e9;
    walk_ray(solid, pose_.x_m, pose_.y_m, dx, dy, camera_.far_m * slant, [&](std::size_t i, double at) {
      if (!solid.cells[i]) return true;
      hit = at;
      return false;
    });
    if (hit < camera_.near_m * slant) continue;
    walk_ray(solid, pose_.x_m, pose_.y_m, dx, dy, camera_.far_m * slant, [&](std::size_t i, double) {
      learn(i, solid.cells[i] ? CellState::occupied : CellState::free);
      return !solid.cells[i];
    });
  }
}

bool FlatSim::step(double forward_mps, double turn_radps) {
  ++steps_;
  const double v = std::clamp(forward_mps, -limits_.speed_mps / 2, limits_.speed_mps);
  const double w = std::clamp(turn_radps, -limits_.turn_radps, limits_.turn_radps);
  hal::PlanarPose next = pose_;
  next.heading_rad = wrap_angle(pose_.heading_rad + w * kStep_s);
  const double middle = pose_.heading_rad + w * kStep_s / 2;
  next.x_m += v * kStep_s * std::cos(middle);
  next.y_m += v * kStep_s * std::sin(middle);
  const Cell c = world_.solid.cell_of(next.x_m, next.y_m);
  bool moved = true;
  if (!clearance_.contains(c) || clearance_.at(c) <= kBodyRadius_m) {
    moved = false;
    ++contacts_;
    const int reach = static_cast<int>(std::ceil(kBodyRadius_m / world_.solid.resolution_m)) + 1;
    double nearest = 1e9;
    std::size_t touched = 0;
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        const Cell n{c.x + dx, c.y + dy};
        const double d = dx * dx + dy * dy;
        if (!world_.solid.contains(n) || !world_.solid.at(n) || d >= nearest) continue;
        nearest = d;
        touched = world_.solid.index(n);
      }
    }
    learn(touched, CellState::occupied);
    next.x_m = pose_.x_m;
    next.y_m = pose_.y_m;
  } else {
    path_m_ += std::abs(v) * kStep_s;
  }
  turned_rad_ += std::abs(w) * kStep_s;
  const bool same = next == pose_;
  pose_ = next;
  if (!same) look();
  return moved;
}

std::vector<std::uint32_t> FlatSim::take_changed() {
  std::vector<std::uint32_t> out;
  out.swap(changed_);
  return out;
}

}  // namespace g3d::tests
