// SPDX-License-Identifier: Apache-2.0
// Follows a path with a round body that drives and turns: regulated pure pursuit (Macenski et al. 2023) with a turn on
// the spot where the path leaves sideways. Of several arcs to points ahead the fastest allowed is driven, where
// "allowed" is: the body stays clear of occupied cells, it stands still within what is known free along this very arc,
// it turns no faster than it may, and it slows down beside obstacles and before the end.
// One thread; step() allocates nothing.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "hal/twist.hpp"
#include "nav/arc_check.hpp"
#include "nav/cell_grid.hpp"
#include "nav/motion_limits.hpp"
#include "nav/path_track.hpp"

namespace g3d::nav {

struct FollowerConfig {
  MotionLimits limits;
  double goal_tolerance_m = 0.10;
  double heading_tolerance_rad = 0.10;
  double resolution_m = 0.05;         ///< of the grids it will see
  double path_look_m = 3.0;           ///< how far ahead the path is checked against the costs
  double beside_obstacle_mps = 0.30;  ///< speed when the body all but touches; rises to the full one at kNoticed_m
};

enum class FollowerState : std::uint8_t {
  idle,  ///< no path
  driving,
  turning,   ///< on the spot, towards the path
  aligning,  ///< on the spot, at the end, towards the final heading
  arrived,
};

/// What holds the speed down.
enum class SpeedLimiter : std::uint8_t {
  none,
  goal,
  curvature,
  clearance,  ///< beside an obstacle
  tight,      ///< hardly fits: creeps
  unknown,    ///< floor that nobody has seen: creeps
  obstacle,
};

class Follower {
 public:
  explicit Follower(const FollowerConfig& config);

  /// Replaces the path while driving. Without a final heading it arrives when the place is reached. A path of one
  /// point, or none, with a heading: turn here.
  void set_path(std::span<const Waypoint> path, std::optional<double> final_heading_rad);
  void clear();

  /// The velocity to command now. `ground` and `cost` have one geometry.
  [[nodiscard]] hal::Twist step(const hal::PlanarPose& T_world_base, const hal::Twist& velocity,
                                const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost,
                                const FloorKnowledge* floor = nullptr);

  [[nodiscard]] FollowerState state() const { return state_; }
  [[nodiscard]] SpeedLimiter limiter() const { return limiter_; }
  /// Distance along the path to the first cell of it where the body cannot be (any more).
  [[nodiscard]] std::optional<double> blocked_at_m() const { return blocked_at_m_; }
  /// No arc is allowed and turning does not help: the way is shut right in front of the body.
  [[nodiscard]] bool is_shut() const { return is_shut_; }
  [[nodiscard]] const PathTrack& track() const { return track_; }
  [[nodiscard]] const ArcCheck& surroundings() const { return check_; }

 private:
  struct Choice {
    double speed_mps = 0.0;
    double curvature_per_m = 0.0;
    SpeedLimiter limiter = SpeedLimiter::none;
    bool leads_unwatched = false;  ///< over floor where somebody may have come unseen
  };
  [[nodiscard]] Choice choose_arc(const hal::PlanarPose& T_world_base, bool trusts_own_way) const;
  [[nodiscard]] Choice allowed(double curvature_per_m, bool trusts_own_way) const;
  [[nodiscard]] double bearing_rad(const hal::PlanarPose& T_world_base, double ahead_m) const;
  void look_along_path(const hal::PlanarPose& T_world_base, const CellGrid<std::uint8_t>& cost);
  [[nodiscard]] hal::Twist turn(double error_rad, const hal::Twist& velocity);
  [[nodiscard]] hal::Twist align(const hal::PlanarPose& T_world_base, const hal::Twist& velocity);

  FollowerConfig config_;
  ArcCheck check_;
  PathTrack track_;
  std::optional<double> final_heading_rad_;
  std::optional<double> blocked_at_m_;
  FollowerState state_ = FollowerState::idle;
  SpeedLimiter limiter_ = SpeedLimiter::none;
  bool at_end_ = false;
  bool is_shut_ = false;
  bool is_turning_to_path_ = false;
  double turn_sign_ = 0.0;  ///< kept while turning through half a turn, where left and right are equal
};

}  // namespace g3d::nav
