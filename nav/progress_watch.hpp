// SPDX-License-Identifier: Apache-2.0
// Whether the robot gets on: in the small (it is told to move and does) and in the large (it gets anywhere at all).
#pragma once

#include <cmath>

#include "hal/messages.hpp"
#include "hal/twist.hpp"
#include "nav/motion_limits.hpp"

namespace g3d::nav {

class ProgressWatch {
 public:
  ProgressWatch(double stuck_s, double lost_s) : stuck_ns_(to_ns(stuck_s)), lost_ns_(to_ns(lost_s)) {}

  /// Begins anew, here.
  void start(const hal::PlanarPose& T_world_base, hal::TimeNs now) {
    moved_from_ = got_from_ = T_world_base;
    moved_ns_ = got_ns_ = now;
  }
  /// It had to stand for so long: that does not count.
  void leave_out(hal::TimeNs duration_ns) {
    moved_ns_ += duration_ns;
    got_ns_ += duration_ns;
  }
  /// What it does now needs no motion, or it has just achieved something.
  void note_moved(const hal::PlanarPose& T_world_base, hal::TimeNs now) {
    moved_from_ = T_world_base;
    moved_ns_ = now;
  }
  void note_got_on(const hal::PlanarPose& T_world_base, hal::TimeNs now) {
    got_from_ = T_world_base;
    got_ns_ = now;
  }
  /// Once per step, with the velocity that it is told.
  void step(const hal::Twist& twist, const hal::PlanarPose& T_world_base, hal::TimeNs now) {
    const bool should_move = std::fabs(twist.forward_mps) > 0.03 || std::fabs(twist.turn_radps) > 0.1;
    const bool moves = distance_m(T_world_base, moved_from_) > kMoves_m ||
                       std::fabs(wrap_angle(T_world_base.heading_rad - moved_from_.heading_rad)) > kMoves_rad;
    if (!should_move || moves) note_moved(T_world_base, now);
    if (distance_m(T_world_base, got_from_) > kGotOn_m) note_got_on(T_world_base, now);
  }
  [[nodiscard]] bool is_stuck(hal::TimeNs now) const { return now - moved_ns_ >= stuck_ns_; }
  [[nodiscard]] bool is_lost(hal::TimeNs now) const { return now - got_ns_ >= lost_ns_; }

 private:
  static constexpr double kMoves_m = 0.05;
  static constexpr double kMoves_rad = 0.15;
  static constexpr double kGotOn_m = 0.5;
  static hal::TimeNs to_ns(double seconds) { return static_cast<hal::TimeNs>(seconds * 1e9); }
  static double distance_m(const hal::PlanarPose& a, const hal::PlanarPose& b) {
    return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
  }

  hal::TimeNs stuck_ns_;
  hal::TimeNs lost_ns_;
  hal::PlanarPose moved_from_;
  hal::PlanarPose got_from_;
  hal::TimeNs moved_ns_ = 0;
  hal::TimeNs got_ns_ = 0;
};

}  // namespace g3d::nav
