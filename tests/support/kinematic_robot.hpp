// SPDX-License-Identifier: Apache-2.0
// A round robot in a flat world of boxes: late and limited in acceleration like the real base, seeing a slice of the
// floor like the real camera. For tests of what drives it; contacts are judged against the boxes, not the cells.
#pragma once

#include <deque>
#include <vector>

#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"

namespace g3d::tests {

struct Box {
  double x0_m, y0_m, x1_m, y1_m;
};

inline constexpr double kKinematicBody_m = 0.178;

class KinematicRobot {
 public:
  /// Commands take effect `latency_steps` steps late.
  KinematicRobot(std::vector<Box> boxes, const hal::PlanarPose& T_world_base, int latency_steps = 3);

  /// Accelerates towards `wanted` and moves. A body that would enter a box stays where it is and stops.
  void step(const hal::Twist& wanted, double dt_s);
  /// Marks what the camera sees from here: 57 degrees, readings from 0.8 to 3.5 m, nothing of what is nearer.
  void see(nav::CellGrid<nav::CellState>& ground) const;

  [[nodiscard]] const hal::PlanarPose& pose() const { return pose_; }
  [[nodiscard]] const hal::Twist& velocity() const { return velocity_; }
  [[nodiscard]] double clearance_m() const;  ///< from the body to the nearest box, at most 10 m
  [[nodiscard]] double least_clearance_m() const { return least_clearance_m_; }
  [[nodiscard]] bool is_touching() const { return is_touching_; }
  [[nodiscard]] int contacts() const { return contacts_; }
  [[nodiscard]] double fastest_contact_mps() const { return fastest_contact_mps_; }
  [[nodiscard]] double path_m() const { return path_m_; }
  [[nodiscard]] double rotation_rad() const { return rotation_rad_; }
  [[nodiscard]] std::vector<Box>& boxes() { return boxes_; }
  [[nodiscard]] const std::vector<Box>& boxes() const { return boxes_; }
  /// What no camera sees, and bodies touch all the same.
  [[nodiscard]] std::vector<Box>& glass() { return glass_; }
  /// Wheels that turn in vain.
  bool is_stuck = false;

 private:
  std::vector<Box> boxes_;
  std::vector<Box> glass_;
  hal::PlanarPose pose_;
  hal::Twist velocity_;
  std::deque<hal::Twist> on_the_way_;
  double least_clearance_m_ = 10.0;
  bool is_touching_ = false;
  int contacts_ = 0;
  double fastest_contact_mps_ = 0.0;
  double path_m_ = 0.0;
  double rotation_rad_ = 0.0;
};

/// Every cell that a box covers in part is occupied, the others free.
[[nodiscard]] nav::CellGrid<nav::CellState> known_floor(const std::vector<Box>& boxes, const Box& extent,
                                                        double resolution_m = 0.05);
/// Costs as costmap_2d defines them, computed the plain way; unknown cells that nothing inflates are kUnknownCost.
[[nodiscard]] nav::CellGrid<std::uint8_t> plain_costs(const nav::CellGrid<nav::CellState>& ground,
                                                      double inscribed_m = 0.18, double inflation_m = 0.45);

}  // namespace g3d::tests
