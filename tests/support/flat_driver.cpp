// SPDX-License-Identifier: Apache-2.0
#include "tests/support/flat_driver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace g3d::tests {

using nav::Cell;
using nav::CellGrid;

namespace {

constexpr int kDx[8] = {1, 1, 0, -1, -1, -1, 0, 1};
constexpr int kDy[8] = {0, 1, 1, 1, 0, -1, -1, -1};
constexpr double kLookahead_m = 0.6;
constexpr double kArrived_m = 0.08;
constexpr double kArrived_rad = 0.05;
constexpr int kWayOut_cells = 3;
constexpr int kWayOutCost = 2000;
constexpr int kCareful_steps = 15;
constexpr int kBackOff_steps = 4;

int cost_of(std::uint8_t cost, bool through_unknown) {
  if (cost == nav::kUnknownCost) return through_unknown ? 64 : -1;
  return cost >= nav::kInscribedCost ? -1 : 64 + cost;
}

}  // namespace

std::vector<Cell> FlatPlanner::plan(const CellGrid<std::uint8_t>& cost, Cell from, Cell to, bool through_unknown) {
  if (!cost.contains(from) || !cost.contains(to) || cost_of(cost.at(to), through_unknown) < 0) return {};
  constexpr std::int32_t kNever = std::numeric_limits<std::int32_t>::max();
  if (distance_.size() != cost.cells.size()) {
    distance_.assign(cost.cells.size(), kNever);
    came_.assign(cost.cells.size(), 0);
    touched_.clear();
  }
  for (const std::uint32_t i : touched_) distance_[i] = kNever;
  touched_.clear();
  heap_.clear();
  const auto estimate = [&](Cell c) {
    const int dx = std::abs(c.x - to.x);
    const int dy = std::abs(c.y - to.y);
    return 64 * (10 * std::max(dx, dy) + 4 * std::min(dx, dy));
  };
  const auto later = [](const Open& a, const Open& b) {
    return a.estimate != b.estimate ? a.estimate > b.estimate : a.cell > b.cell;
  };
  const auto push = [&](Cell c, std::int32_t d, int direction) {
    const std::uint32_t i = static_cast<std::uint32_t>(cost.index(c));
    if (d >= distance_[i]) return;
    if (distance_[i] == kNever) touched_.push_back(i);
    distance_[i] = d;
    came_[i] = static_cast<std::uint8_t>(direction);
    heap_.push_back({d + estimate(c), i});
    std::push_heap(heap_.begin(), heap_.end(), later);
  };
  push(from, 0, 0);
  const std::uint32_t goal = static_cast<std::uint32_t>(cost.index(to));
  const std::uint32_t start = static_cast<std::uint32_t>(cost.index(from));
  while (!heap_.empty()) {
    const Open top = heap_.front();
    std::pop_heap(heap_.begin(), heap_.end(), later);
    heap_.pop_back();
    const Cell c = cost.cell(top.cell);
    const std::int32_t d = distance_[top.cell];
    if (top.estimate > d + estimate(c)) continue;
    if (top.cell == goal) break;
    for (int k = 0; k < 8; ++k) {
      const Cell n{c.x + kDx[k], c.y + kDy[k]};
      if (!cost.contains(n)) continue;
      int w = cost_of(cost.at(n), through_unknown);
      // Out of where it stands too near to something.
      const bool beside_start = std::abs(n.x - from.x) <= kWayOut_cells && std::abs(n.y - from.y) <= kWayOut_cells;
      if (w < 0 && beside_start && cost.at(n) == nav::kInscribedCost) w = kWayOutCost;
      if (w < 0) continue;
      push(n, d + w * (k % 2 == 0 ? 10 : 14), k);
    }
  }
  if (distance_[goal] == kNever) return {};
  std::vector<Cell> path;
  for (std::uint32_t i = goal;;) {
    const Cell c = cost.cell(i);
    path.push_back(c);
    if (i == start) break;
    const int k = came_[i];
    i = static_cast<std::uint32_t>(cost.index({c.x - kDx[k], c.y - kDy[k]}));
  }
  std::reverse(path.begin(), path.end());
  return path;
}

void FlatDriver::set_goal(const hal::PlanarPose& goal, const CellGrid<std::uint8_t>* costs) {
  costs_ = costs != nullptr ? costs : &sim_.cost();
  goal_ = goal;
  turning_ = false;
  blocked_ = 0;
  progress_ = sim_.pose();
  progress_s_ = sim_.time_s();
  replan();
}

void FlatDriver::replan() {
  const Cell from = costs_->cell_of(sim_.pose().x_m, sim_.pose().y_m);
  path_ = planner_.plan(*costs_, from, costs_->cell_of(goal_.x_m, goal_.y_m), through_unknown_);
  next_ = 0;
}

bool FlatDriver::is_passable(Cell c) const { return cost_of(costs_->at(c), through_unknown_) >= 0; }

bool FlatDriver::line_is_clear(Cell a, Cell b, int worst) const {
  const int n = std::max(std::abs(a.x - b.x), std::abs(a.y - b.y));
  for (int i = 1; i <= n; ++i) {
    const Cell c{a.x + static_cast<int>(std::lround(static_cast<double>(b.x - a.x) * i / n)),
                 a.y + static_cast<int>(std::lround(static_cast<double>(b.y - a.y) * i / n))};
    const int w = cost_of(costs_->at(c), through_unknown_);
    if (w < 0 || w > worst) return false;
  }
  return true;
}

DriveState FlatDriver::step() {
  const hal::PlanarPose& at = sim_.pose();
  if (std::hypot(at.x_m - progress_.x_m, at.y_m - progress_.y_m) > 0.1 || turning_) {
    progress_ = at;
    progress_s_ = sim_.time_s();
  } else if (sim_.time_s() - progress_s_ > 15.0) {
    return DriveState::stuck;
  }
  const double to_goal = std::hypot(goal_.x_m - at.x_m, goal_.y_m - at.y_m);
  if (turning_ || to_goal < kArrived_m) {
    turning_ = true;
    const double error = wrap_angle(goal_.heading_rad - at.heading_rad);
    if (std::abs(error) < kArrived_rad) return DriveState::arrived;
    sim_.step(0.0, error / FlatSim::kStep_s);
    return DriveState::driving;
  }
  if (bumped_ > kCareful_steps) {
    --bumped_;
    sim_.step(-0.2, 0.0);
    return DriveState::driving;
  }
  if (path_.empty()) return DriveState::no_path;
  const Cell here = costs_->cell_of(at.x_m, at.y_m);
  // The part of the path that lies ahead: from its nearest cell on.
  const auto apart = [&](std::size_t i) {
    const double dx = costs_->centre_x_m(path_[i]) - at.x_m;
    const double dy = costs_->centre_y_m(path_[i]) - at.y_m;
    return dx * dx + dy * dy;
  };
  while (next_ + 1 < path_.size() && apart(next_ + 1) <= apart(next_)) ++next_;
  for (std::size_t i = next_; i < std::min(next_ + 30, path_.size()); ++i) {
    if (is_passable(path_[i]) || apart(i) < 0.25 * 0.25) continue;
    replan();
    if (path_.empty()) return DriveState::no_path;
    break;
  }
  int worst = 64;
  std::size_t aim = std::min(next_ + 2, path_.size() - 1);
  // Beside something that it bumped into, cell by cell.
  const std::size_t reach = next_ + static_cast<std::size_t>(kLookahead_m / costs_->resolution_m);
  if (bumped_ > 0) aim = std::min(next_ + 1, path_.size() - 1);
  for (std::size_t i = next_; bumped_ == 0 && i < std::min(reach + 1, path_.size()); ++i) {
    worst = std::max(worst, cost_of(costs_->at(path_[i]), through_unknown_));
    if (line_is_clear(here, path_[i], worst)) aim = i;
  }
  double tx = costs_->centre_x_m(path_[aim]);
  double ty = costs_->centre_y_m(path_[aim]);
  if (aim + 1 == path_.size()) {
    tx = goal_.x_m;
    ty = goal_.y_m;
  }
  const double distance = std::hypot(tx - at.x_m, ty - at.y_m);
  const double error = wrap_angle(std::atan2(ty - at.y_m, tx - at.x_m) - at.heading_rad);
  in_place_ = std::abs(error) > (in_place_ ? 0.15 : 0.6);
  const double turn = std::clamp(error / (in_place_ ? FlatSim::kStep_s : 0.3), -1.0, 1.0);
  const double speed =
      in_place_ ? 0.0 : std::min(0.4 * std::max(0.2, 1.0 - std::abs(error)), distance / FlatSim::kStep_s);
  if (!sim_.step(speed, turn)) {
    if (++blocked_ > 20) return DriveState::stuck;
    bumped_ = kCareful_steps + kBackOff_steps;
    replan();
  } else if (bumped_ > 0) {
    --bumped_;
  }
  return DriveState::driving;
}

}  // namespace g3d::tests
