// SPDX-License-Identifier: Apache-2.0
#include "tests/support/explore_lite.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>

#include "tests/support/flat_driver.hpp"

namespace g3d::tests {

using nav::Cell;
using nav::CellState;

namespace {

struct Point {
  double x_m = 0.0;
  double y_m = 0.0;
};

struct Frontier {
  Point centroid;
  int size_cells = 0;
  double distance_m = 1e9;  ///< Euclidean, from the robot to the nearest cell
  double cost = 0.0;
};

class ExploreLite {
 public:
  ExploreLite(FlatSim& sim, const ExploreLiteConfig& config) : sim_(sim), config_(config) {}

  enum class Plan { keep, drive, stop };

  /// makePlan() of the original.
  Plan make_plan() {
    std::vector<Frontier> frontiers = search();
    for (;;) {
      const auto chosen = std::find_if(frontiers.begin(), frontiers.end(),
                                       [&](const Frontier& f) { return !on_blacklist(f.centroid); });
      if (chosen == frontiers.end()) return Plan::stop;
      const bool same = goal_ && goal_->x_m == chosen->centroid.x_m && goal_->y_m == chosen->centroid.y_m;
      goal_ = chosen->centroid;
      if (!same || last_distance_m_ > chosen->distance_m) {
        last_progress_s_ = sim_.time_s();
        last_distance_m_ = chosen->distance_m;
      }
      if (sim_.time_s() - last_progress_s_ > config_.progress_timeout_s) {
        blacklist_.push_back(*goal_);
        continue;
      }
      return same ? Plan::keep : Plan::drive;
    }
  }

  void abort() {
    if (goal_) blacklist_.push_back(*goal_);
  }
  [[nodiscard]] Point goal() const { return *goal_; }

 private:
  [[nodiscard]] bool on_blacklist(Point p) const {
    const double tolerance = 5 * sim_.ground().resolution_m;
    return std::any_of(blacklist_.begin(), blacklist_.end(), [&](Point b) {
      return std::abs(p.x_m - b.x_m) < tolerance && std::abs(p.y_m - b.y_m) < tolerance;
    });
  }

  [[nodiscard]] std::vector<Cell> beside(Cell c, bool diagonal) const {
    static constexpr int kDx[8] = {1, -1, 0, 0, 1, 1, -1, -1};
    static constexpr int kDy[8] = {0, 0, 1, -1, 1, -1, 1, -1};
    std::vector<Cell> out;
    for (int k = 0; k < (diagonal ? 8 : 4); ++k) {
      const Cell n{c.x + kDx[k], c.y + kDy[k]};
      if (sim_.ground().contains(n)) out.push_back(n);
    }
    return out;
  }

  [[nodiscard]] bool is_new_frontier(Cell c, const std::vector<std::uint8_t>& taken) const {
    const auto& ground = sim_.ground();
    if (ground.at(c) != CellState::unknown || taken[ground.index(c)]) return false;
    const std::vector<Cell> near = beside(c, false);
    return std::any_of(near.begin(), near.end(), [&](Cell n) { return ground.at(n) == CellState::free; });
  }

  /// searchFrom() of the original.
  std::vector<Frontier> search() const {
    const auto& ground = sim_.ground();
    std::vector<std::uint8_t> visited(ground.cells.size(), 0);
    std::vector<std::uint8_t> taken(ground.cells.size(), 0);
    std::vector<Frontier> out;
    const Cell at = ground.cell_of(sim_.pose().x_m, sim_.pose().y_m);
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

  Frontier build(Cell first, std::vector<std::uint8_t>& taken) const {
    const auto& ground = sim_.ground();
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
      out.distance_m = std::min(out.distance_m, std::hypot(x - sim_.pose().x_m, y - sim_.pose().y_m));
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

  FlatSim& sim_;
  ExploreLiteConfig config_;
  std::optional<Point> goal_;
  double last_distance_m_ = 0.0;
  double last_progress_s_ = 0.0;
  std::vector<Point> blacklist_;
};

}  // namespace

FlatResult run_explore_lite(FlatSim& sim, double limit_s, const ExploreLiteConfig& config) {
  FlatResult result;
  ExploreLite explorer(sim, config);
  FlatDriver driver(sim, true);
  bool has_goal = false;
  double next_plan_s = 0.0;
  while (sim.time_s() < limit_s) {
    if (sim.time_s() >= next_plan_s) {
      next_plan_s = sim.time_s() + config.period_s;
      const ExploreLite::Plan plan = explorer.make_plan();
      if (plan == ExploreLite::Plan::stop) {
        result.ended = true;
        break;
      }
      if (plan == ExploreLite::Plan::drive) {
        driver.set_goal({explorer.goal().x_m, explorer.goal().y_m, 0.0});
        has_goal = true;
        ++result.goals;
      }
    }
    const DriveState state = has_goal ? driver.step() : DriveState::arrived;
    if (state == DriveState::driving) {
      note_progress(sim, result);
      continue;
    }
    if (state != DriveState::arrived) explorer.abort();
    // The original plans anew at once; time goes on even where it stands still.
    sim.step(0.0, 0.0);
    if (has_goal) next_plan_s = sim.time_s();
    has_goal = false;
  }
  note_end(sim, result);
  return result;
}

}  // namespace g3d::tests
