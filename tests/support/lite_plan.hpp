// SPDX-License-Identifier: Apache-2.0
// A yardstick: greedy frontier exploration as the ROS package explore_lite does it, with its published parameters.
// Frontiers are connected unknown cells beside free ones that a breadth-first search from the robot meets; the goal is
// a frontier's centroid, with heading 0; failed goals and those without progress are never tried again.
#pragma once

#include <optional>
#include <vector>

#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"

namespace g3d::tests {

struct ExploreLiteConfig {
  double potential_scale = 3.0;
  double gain_scale = 1.0;
  double min_frontier_m = 0.75;
  double period_s = 3.0;  ///< 0.33 Hz
  double progress_timeout_s = 30.0;
};

class ExploreLite {
 public:
  enum class Plan { keep, drive, stop };
  struct Point {
    double x_m = 0.0;
    double y_m = 0.0;
  };

  explicit ExploreLite(const ExploreLiteConfig& config) : config_(config) {}

  /// makePlan() of the original.
  Plan make_plan(const nav::CellGrid<nav::CellState>& ground, const hal::PlanarPose& pose, double time_s);
  /// The goal was given up by whoever drives.
  void abort() {
    if (goal_) blacklist_.push_back(*goal_);
  }
  [[nodiscard]] Point goal() const { return *goal_; }

 private:
  [[nodiscard]] bool on_blacklist(Point p, double resolution_m) const;

  ExploreLiteConfig config_;
  std::optional<Point> goal_;
  double last_distance_m_ = 0.0;
  double last_progress_s_ = 0.0;
  std::vector<Point> blacklist_;
};

}  // namespace g3d::tests
