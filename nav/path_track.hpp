// SPDX-License-Identifier: Apache-2.0
// Where a robot is along a path: the nearest point of it, never jumping back or across a loop, and points ahead of it.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "nav/path_smoothing.hpp"

namespace g3d::nav {

class PathTrack {
 public:
  explicit PathTrack(std::size_t max_points = 4096);

  /// Copies; what is beyond max_points is cut. Progress begins at the start.
  void set(std::span<const Waypoint> path);
  void clear();
  [[nodiscard]] bool empty() const { return points_.empty(); }
  [[nodiscard]] std::span<const Waypoint> points() const { return points_; }

  /// Moves on to the point nearest to the robot, looking at most kWindow_m ahead.
  void advance(double x_m, double y_m);

  [[nodiscard]] double travelled_m() const { return travelled_m_; }
  [[nodiscard]] double remaining_m() const { return length_m() - travelled_m_; }
  [[nodiscard]] double length_m() const { return at_m_.empty() ? 0.0 : at_m_.back(); }
  /// Distance of the robot from the path at the last advance().
  [[nodiscard]] double offset_m() const { return offset_m_; }
  /// The point this far along the path from where the robot is; its end if that is nearer. Not for an empty path.
  [[nodiscard]] Waypoint ahead(double distance_m) const;

  static constexpr double kWindow_m = 1.0;

 private:
  [[nodiscard]] Waypoint at(double along_m) const;

  std::size_t max_points_;
  std::vector<Waypoint> points_;
  std::vector<double> at_m_;  ///< length of the path up to each point
  double travelled_m_ = 0.0;
  double offset_m_ = 0.0;
};

}  // namespace g3d::nav
