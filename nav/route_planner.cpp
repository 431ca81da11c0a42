// SPDX-License-Identifier: Apache-2.0
#include "nav/route_planner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "nav/path_centring.hpp"

namespace g3d::nav {
namespace {

constexpr std::size_t kMaxPathCells = 1U << 16;
constexpr int kMaxTolerance_cells = 30;

constexpr double kWide_m = 0.25;  // with more to all sides a path may lead where it likes

constexpr double kAway_m = 1.0;
constexpr int kMostAway_cells = 64;

}  // namespace

bool is_hemmed_in(const CellGrid<std::uint8_t>& cost, const hal::PlanarPose& from) {
  constexpr std::size_t kSide = 2 * kMostAway_cells + 1;
  const int reach = std::clamp(static_cast<int>(kAway_m / cost.resolution_m), 1, kMostAway_cells);
  const Cell start = cost.cell_of(from.x_m, from.y_m);
  if (!cost.contains(start)) return true;
  const int relief = StepOptions{}.relief_cells;
  std::array<bool, kSide * kSide> was_met{};
  std::array<Cell, kSide * kSide> queue;
  std::size_t end = 0;
  const auto meet = [&](int dx, int dy) {
    const Cell c{start.x + dx, start.y + dy};
    bool& met = was_met[static_cast<std::size_t>(dy + kMostAway_cells) * kSide +
                        static_cast<std::size_t>(dx + kMostAway_cells)];
    if (met || !cost.contains(c)) return;
    const bool is_near = std::max(std::abs(dx), std::abs(dy)) <= relief;
    if (cost.at(c) > (is_near ? kInscribedCost : kInscribedCost - 1)) return;
    met = true;
    queue[end++] = {dx, dy};
  };
  queue[end++] = {0, 0};
  for (std::size_t i = 0; i < end; ++i) {
    const auto [dx, dy] = queue[i];
    if (std::max(std::abs(dx), std::abs(dy)) >= reach) return false;
    meet(dx + 1, dy);
    meet(dx - 1, dy);
    meet(dx, dy + 1);
    meet(dx, dy - 1);
  }
  return true;
}

RoutePlanner::RoutePlanner(std::size_t max_cells) : astar_(max_cells), smoother_(kMaxPathCells) {
  constexpr std::size_t kSide = 2 * kMaxTolerance_cells + 1;
  goals_.reserve(kSide * kSide);
  points_.reserve(2 * kMaxPathCells);
}

// The goal itself if the body fits there, else all cells of the nearest ring that has any.
void RoutePlanner::choose_goals(const CellGrid<std::uint8_t>& cost, Cell goal, double tolerance_m) {
  goals_.clear();
  const int reach = std::clamp(static_cast<int>(tolerance_m / cost.resolution_m), 0, kMaxTolerance_cells);
  for (int ring = 0; ring <= reach && goals_.empty(); ++ring) {
    for (int y = -ring; y <= ring; ++y) {
      for (int x = -ring; x <= ring; ++x) {
        if (std::max(std::abs(x), std::abs(y)) != ring) continue;
        const Cell c{goal.x + x, goal.y + y};
        if (cost.contains(c) && cost.at(c) < kInscribedCost) goals_.push_back(c);
      }
    }
  }
}

Route RoutePlanner::plan(const CellGrid<std::uint8_t>& cost, const hal::PlanarPose& from, const hal::PlanarPose& to,
                         double tolerance_m) {
  choose_goals(cost, cost.cell_of(to.x_m, to.y_m), tolerance_m);
  Route route;
  points_.clear();
  if (goals_.empty()) {
    route.status = PathStatus::goal_blocked;
    return route;
  }
  const PathResult path = astar_.plan(cost, cost.cell_of(from.x_m, from.y_m), goals_);
  route.status = path.status;
  route.expansions = path.expansions;
  if (path.status != PathStatus::found) return route;
  const std::span<const Waypoint> smooth = smoother_.smooth(cost, path.cells);
  points_.push_back({from.x_m, from.y_m});
  // The centre of the first cell may lie behind the robot or beside it.
  for (std::size_t i = 1; i < smooth.size() && points_.size() < points_.capacity(); ++i) points_.push_back(smooth[i]);
  // What the goal's cell is the centre of is not quite the goal.
  const Cell end = path.cells.back();
  if (end == cost.cell_of(to.x_m, to.y_m) && points_.size() > 1) points_.back() = {to.x_m, to.y_m};
  centre_path(cost, points_, kWide_m);
  for (std::size_t i = 1; i < points_.size(); ++i) {
    route.length_m += std::hypot(points_[i].x_m - points_[i - 1].x_m, points_[i].y_m - points_[i - 1].y_m);
  }
  route.points = points_;
  return route;
}

}  // namespace g3d::nav
