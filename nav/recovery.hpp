// SPDX-License-Identifier: Apache-2.0
// What the robot does when it cannot go on, in this order, and always to an end: wait (what stands there may walk
// away), back off over cells known to be free, turn and look, give the goal up. After each of these a new path is asked
// for; a path that leads nowhere continues with the next one. A pure state machine: all it knows is handed in.
//
//   idle -- start() --> [ waiting ] --> [ backing ] --> [ turning ] --> asking -- answer(found) --> idle
//                            ^_______________________________________________| answer(none): next attempt
//                                                                            `--> gave_up, after the last one
#pragma once

#include <cstdint>

#include "hal/messages.hpp"
#include "hal/twist.hpp"
#include "nav/motion_limits.hpp"

namespace g3d::nav {

using hal::TimeNs;

enum class Trouble : std::uint8_t {
  contact,      ///< a bumper was pressed
  shut,         ///< the way in front of the body is occupied
  no_progress,  ///< it should move and does not
  no_path,      ///< the planner finds nothing from here
};

enum class RecoveryPhase : std::uint8_t { idle, waiting, backing, turning, asking, gave_up };

struct RecoveryConfig {
  MotionLimits limits;
  double wait_s = 2.0;
  double back_m = 0.15;     ///< first time; twice as far afterwards
  double turn_rad = 1.2;    ///< away from the trouble, then all around
  double progress_m = 0.6;  ///< this far from the last trouble counts as having got away from it
  int max_attempts = 4;
  double max_phase_s = 8.0;
  double max_total_s = 45.0;  ///< of one trouble, until the goal is given up
};

struct RecoveryView {
  TimeNs now_ns = 0;
  hal::PlanarPose T_world_base;
  double free_behind_m = 0.0;  ///< straight back, over cells known to be free
  bool is_touching = false;
};

class Recovery {
 public:
  explicit Recovery(const RecoveryConfig& config);

  /// `side`: +1 if what is in the way is on the left, -1 right, 0 ahead. Near the last trouble it counts as the same
  /// one and continues with the next attempt.
  void start(Trouble trouble, double side, const RecoveryView& view);
  /// The velocity to command now.
  [[nodiscard]] hal::Twist step(const RecoveryView& view);
  /// In phase asking: a path was found (it ends here, for now) or not.
  void answer(bool has_path, const RecoveryView& view);
  /// Ends it here, whatever phase it is in; trouble again nearby continues with the next attempt.
  void end() { phase_ = RecoveryPhase::idle; }
  /// Ends it and forgets it: it got away from there, or gave up.
  void reset();

  [[nodiscard]] RecoveryPhase phase() const { return phase_; }
  [[nodiscard]] bool is_active() const { return phase_ != RecoveryPhase::idle; }
  [[nodiscard]] Trouble trouble() const { return trouble_; }
  [[nodiscard]] int attempts() const { return attempt_; }

 private:
  void begin_attempt(const RecoveryView& view);
  void enter(RecoveryPhase phase, const RecoveryView& view);
  void leave_phase(const RecoveryView& view);
  [[nodiscard]] double travelled_m(const RecoveryView& view) const;

  RecoveryConfig config_;
  RecoveryPhase phase_ = RecoveryPhase::idle;
  Trouble trouble_ = Trouble::no_progress;
  double side_ = 0.0;
  int attempt_ = 0;
  TimeNs first_ns_ = 0;
  hal::PlanarPose first_pose_;
  bool has_trouble_ = false;
  // Of the phase.
  TimeNs phase_ns_ = 0;
  hal::PlanarPose phase_pose_;
  double last_heading_rad_ = 0.0;
  double turned_rad_ = 0.0;
  // Of the attempt; 0 leaves the phase out.
  double wait_s_ = 0.0;
  double back_m_ = 0.0;
  double turn_rad_ = 0.0;
};

}  // namespace g3d::nav
