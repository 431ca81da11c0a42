// SPDX-License-Identifier: Apache-2.0
#include "tests/support/lite_plan.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>

namespace g3d::tests {

using nav::Cell;
using nav::CellState;
using Point = ExploreLite::Point;

namespace {

struct Frontier {
  Point centroid;
  int size_cells = 0;
  double distance_m = 1e9;  ///< Euclidean, from the robot to the nearest cell
  double cost = 0.0;
};

/// frontier_search of the original, on one map from one pose.
class FrontierSearch {
 public:
  FrontierSearch(const nav::CellGrid<nav::CellState>& ground, const hal::PlanarPose& pose,
                 const ExploreLiteConfig& config)
      : ground_(ground), pose_(pose), config_(config) {}

  /// searchFrom() of the original.
  [[nodiscard]] std::vector<Frontier> search() const {
    const auto& ground = ground_;
    std::vector<std::uint8_t> visited(ground.cells.size(), 0);
    std::vector<std::uint8_t> taken(ground.cells.size(), 0);
    std::vector<Frontier> out;
    const Cell at = ground.cell_of(pose_.x_m, pose_.y_m);
    std::deque<Cell> open{at};
    visited[ground.index(at)] = 1;
    while (!open.empty()) {
      const Cell c = open.front();
      open.pop_front();
      for (const Cell n : beside(c, false)) {
        if (ground.at(n) == CellState::free && !visited[ground.index(n)]) {
          visited[ground.index(n)] = 1;
          open.push_back(n);
        } else if (is_new_frontier(n, taken)) {
          taken[ground.index(n)] = 1;
          Frontier frontier = build(n, taken);
          if (frontier.size_cells * ground.resolution_m < config_.min_frontier_m) continue;
          frontier.cost = config_.potential_scale * frontier.distance_m * ground.resolution_m -
                          config_.gain_scale * frontier.size_cells * ground.resolution_m;
          out.push_back(frontier);
        }
      }
    }
    std::stable_sort(out.begin(), out.end(), [](const Frontier& a, const Frontier& b) { return a.cost < b.cost; });
    return out;
  }

 private:
  [[nodiscard]] std::vector<Cell> beside(Cell c, bool diagonal) const {
    static constexpr int kDx[8] = {1, -1, 0, 0, 1, 1, -1, -1};
    static constexpr int kDy[8] = {0, 0, 1, -1, 1, -1, 1, -1};
    std::vector<Cell> out;
    for (int k = 0; k < (diagonal ? 8 : 4); ++k) {
      const Cell n{c.x + kDx[k], c.y + kDy[k]};
      if (ground_.contains(n)) out.push_back(n);
    }
    return out;
  }

  [[nodiscard]] bool is_new_frontier(Cell c, const std::vector<std::uint8_t>& taken) const {
    const auto& ground = ground_;
    if (ground.at(c) != CellState::unknown || taken[ground.index(c)]) return false;
    const std::vector<Cell> near = beside(c, false);
    return std::any_of(near.begin(), near.end(), [&](Cell n) { return ground.at(n) == CellState::free; });
  }

  Frontier build(Cell first, std::vector<std::uint8_t>& taken) const {
    const auto& ground = ground_;
    Frontier out;
    std::deque<Cell> open{first};
    while (!open.empty()) {
      const Cell c = open.front();
      open.pop_front();
      ++out.size_cells;
      const double x = ground.centre_x_m(c);
      const double y = ground.centre_y_m(c);
      out.centroid.x_m += x;
      out.centroid.y_m += y;
      out.distance_m = std::min(out.distance_m, std::hypot(x - pose_.x_m, y - pose_.y_m));
      for (const Cell n : beside(c, true)) {
        if (!is_new_frontier(n, taken)) continue;
        taken[ground.index(n)] = 1;
        open.push_back(n);
      }
    }
    out.centroid.x_m /= out.size_cells;
    out.centroid.y_m /= out.size_cells;
    return out;
  }

  const nav::CellGrid<nav::CellState>& ground_;
  const hal::PlanarPose& pose_;
  const ExploreLiteConfig& config_;
};

}  // namespace

ExploreLite::Plan ExploreLite::make_plan(const nav::CellGrid<nav::CellState>& ground, const hal::PlanarPose& pose,
                                         double time_s) {
  std::vector<Frontier> frontiers = FrontierSearch(ground, pose, config_).search();
  for (;;) {
    const auto chosen = std::find_if(frontiers.begin(), frontiers.end(),
                                     [&](const Frontier& f) { return !on_blacklist(f.centroid, ground.resolution_m); });
    if (chosen == frontiers.end()) return Plan::stop;
    const bool same = goal_ && goal_->x_m == chosen->centroid.x_m && goal_->y_m == chosen->centroid.y_m;
    goal_ = chosen->centroid;
    if (!same || last_distance_m_ > chosen->distance_m) {
      last_progress_s_ = time_s;
      last_distance_m_ = chosen->distance_m;
    }
    if (time_s - last_progress_s_ > config_.progress_timeout_s) {
      blacklist_.push_back(*goal_);
      continue;
    }
    return same ? Plan::keep : Plan::drive;
  }
}

bool ExploreLite::on_blacklist(Point p, double resolution_m) const {
  const double tolerance = 5 * resolution_m;
  return std::any_of(blacklist_.begin(), blacklist_.end(), [&](Point b) {
    return std::abs(p.x_m - b.x_m) < tolerance && std::abs(p.y_m - b.y_m) < tolerance;
  });
}

}  // namespace g3d::tests
