// SPDX-License-Identifier: Apache-2.0
// What the robot knows of the floor without its camera: where its body was there is nothing, and where its bumper was
// pressed there is something.
#pragma once

#include <cstdint>

#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"
#include "nav/path_smoothing.hpp"

namespace g3d::nav {

class BodyTrace {
 public:
  /// For a grid of the same geometry.
  BodyTrace(const CellGrid<CellState>& like, double body_radius_m);

  /// The body is here. False if that is where it was already, within kTread_m.
  bool tread(const hal::PlanarPose& T_world_base);
  void clear();
  [[nodiscard]] bool is_trodden(Cell c) const { return trodden_.contains(c) && trodden_.at(c) != 0; }

  static constexpr double kTread_m = 0.02;

 private:
  double body_radius_m_;
  CellGrid<std::uint8_t> trodden_;
  hal::PlanarPose last_pose_;
  bool has_pose_ = false;
};

/// Middle of the left and right parts of the bumper, from the front.
inline constexpr double kBumperSide_rad = 0.9;

/// Where the bumper was touched is known only roughly. If something is known to stand at that part of it, it was that,
/// and it reaches a little farther than was thought; else the middle of the part met what the camera cannot see.
[[nodiscard]] Waypoint where_touched(const CellGrid<CellState>& states, const hal::PlanarPose& T_world_base,
                                     double side_rad, double body_radius_m);

}  // namespace g3d::nav
