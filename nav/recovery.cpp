// SPDX-License-Identifier: Apache-2.0
#include "nav/recovery.hpp"
#include "nav/seconds.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr double kFullTurn_rad = 2.0 * 3.14159265358979323846;
constexpr double kTurnedEnough_rad = 0.05;
constexpr double kNoRoom_m = 0.02;

}  // namespace

Recovery::Recovery(const RecoveryConfig& config) : config_(config) {}

void Recovery::reset() {
  phase_ = RecoveryPhase::idle;
  has_trouble_ = false;
  attempt_ = 0;
}

void Recovery::start(Trouble trouble, double side, const RecoveryView& view) {
  const bool is_same = has_trouble_ && std::hypot(view.T_world_base.x_m - first_pose_.x_m,
                                                  view.T_world_base.y_m - first_pose_.y_m) < config_.progress_m;
  if (!is_same) {
    attempt_ = 0;
    first_ns_ = view.now_ns;
    first_pose_ = view.T_world_base;
    has_trouble_ = true;
  } else if (phase_ == RecoveryPhase::idle || phase_ == RecoveryPhase::turning) {
    ++attempt_;  // a turn that ran into something is not begun again
  }
  trouble_ = trouble;
  side_ = side;
  begin_attempt(view);
}

void Recovery::begin_attempt(const RecoveryView& view) {
  if (attempt_ >= config_.max_attempts || seconds_between(first_ns_, view.now_ns) >= config_.max_total_s) {
    phase_ = RecoveryPhase::gave_up;
    return;
  }
  const bool touched = trouble_ == Trouble::contact;
  wait_s_ = 0.0;
  back_m_ = 0.0;
  turn_rad_ = 0.0;
  switch (attempt_) {
    case 0:
      wait_s_ = trouble_ == Trouble::shut || trouble_ == Trouble::no_path ? config_.wait_s : 0.0;
      back_m_ = touched || trouble_ == Trouble::no_progress ? config_.back_m : 0.0;
      break;
    case 1:
      back_m_ = 2.0 * config_.back_m;
      turn_rad_ = side_ > 0.0 ? -config_.turn_rad : config_.turn_rad;
      break;
    case 2:
      back_m_ = touched ? 2.0 * config_.back_m : 0.0;
      turn_rad_ = side_ > 0.0 ? -kFullTurn_rad : kFullTurn_rad;
      break;
    default:
      wait_s_ = 2.0 * config_.wait_s;
      back_m_ = 2.0 * config_.back_m;
      break;
  }
  enter(RecoveryPhase::waiting, view);
}

void Recovery::enter(RecoveryPhase phase, const RecoveryView& view) {
  phase_ = phase;
  phase_ns_ = view.now_ns;
  phase_pose_ = view.T_world_base;
  last_heading_rad_ = view.T_world_base.heading_rad;
  turned_rad_ = 0.0;
}

void Recovery::leave_phase(const RecoveryView& view) {
  switch (phase_) {
    case RecoveryPhase::waiting:
      return enter(RecoveryPhase::backing, view);
    case RecoveryPhase::backing:
      return enter(RecoveryPhase::turning, view);
    default:
      return enter(RecoveryPhase::asking, view);
  }
}

double Recovery::travelled_m(const RecoveryView& view) const {
  return std::hypot(view.T_world_base.x_m - phase_pose_.x_m, view.T_world_base.y_m - phase_pose_.y_m);
}

hal::Twist Recovery::step(const RecoveryView& view) {
  turned_rad_ += wrap_angle(view.T_world_base.heading_rad - last_heading_rad_);
  last_heading_rad_ = view.T_world_base.heading_rad;
  // Each pass either commands something or goes on to the next phase: asking and gave_up end it.
  while (phase_ == RecoveryPhase::waiting || phase_ == RecoveryPhase::backing || phase_ == RecoveryPhase::turning) {
    const double in_phase_s = seconds_between(phase_ns_, view.now_ns);
    const bool is_late = in_phase_s >= config_.max_phase_s;
    if (phase_ == RecoveryPhase::waiting) {
      if (!is_late && in_phase_s < wait_s_) return {};
    } else if (phase_ == RecoveryPhase::backing) {
      const double left_m = std::min(back_m_ - travelled_m(view), view.free_behind_m);
      if (!is_late && left_m > kNoRoom_m) {
        const double brake_mps =
            speed_to_stop_within(left_m, config_.limits.deceleration_mps2, config_.limits.reaction_s);
        return {-std::clamp(brake_mps, 0.3 * config_.limits.crawl_speed_mps, config_.limits.crawl_speed_mps), 0.0};
      }
    } else {
      const double left_rad = turn_rad_ - turned_rad_;
      if (!is_late && left_rad * turn_rad_ > 0.0 && std::fabs(left_rad) > kTurnedEnough_rad) {
        return {0.0, turn_rate_to(left_rad, config_.limits)};
      }
    }
    leave_phase(view);
  }
  return {};
}

void Recovery::answer(bool has_path, const RecoveryView& view) {
  if (phase_ != RecoveryPhase::asking) return;
  if (has_path) {
    phase_ = RecoveryPhase::idle;
    return;
  }
  ++attempt_;
  begin_attempt(view);
}

}  // namespace g3d::nav
