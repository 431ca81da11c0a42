// SPDX-License-Identifier: Apache-2.0
#include "nav/navigator.hpp"

#include <algorithm>
#include <cmath>

#include "hal/kobuki/feedback.hpp"

namespace g3d::nav {
namespace {

constexpr double kBehind_m = 0.35;
constexpr double kOffPath_m = 0.35;    // farther from the path: another one is better
constexpr double kSlowest_mps = 0.12;  // on average, until a goal takes too long
constexpr double kGoalGrace_s = 25.0;
constexpr double kSpun_rad = 0.05;
constexpr double kAgain_s = 0.1;   // between decisions when one fails after the other,
constexpr double kInVain_s = 1.0;  // and when that goes on
constexpr int kCutOff = 3;         // goals in a row without a path: the robot is cut off from where it came from

TimeNs after(TimeNs now, double seconds) { return now + static_cast<TimeNs>(seconds * 1e9); }

double distance_m(const hal::PlanarPose& a, const hal::PlanarPose& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

ExplorerConfig sized(ExplorerConfig config, const CellGrid<CellState>& states) {
  config.max_cells = std::max(config.max_cells, static_cast<int>(states.cells.size()));
  return config;
}

FollowerConfig fitted(FollowerConfig config, double resolution_m) {
  config.resolution_m = resolution_m;
  return config;
}

}  // namespace

Navigator::Navigator(const mapper::Grid& grid, const NavigatorConfig& config)
    : config_(config),
      floor_(grid, {config.ground, config.low_view, config.near_watch, config.follower.limits.body_radius_m,
                    config.inflation_radius_m, config.inflation_decay_perm}),
      explorer_(std::make_unique<Explorer>(sized(config.explorer, floor_.states()))),
      planner_(floor_.states().cells.size()),
      follower_(fitted(config.follower, floor_.states().resolution_m)),
      behind_(config.follower.limits.body_radius_m, config.follower.limits.touch_margin_m, kBehind_m,
              floor_.states().resolution_m),
      recovery_(config.recovery),
      progress_(config.no_progress_s, config.lost_s) {}

void Navigator::on_map(const mapper::VoxelMap& map, std::span<const std::uint32_t> changed_slots, TimeNs) {
  floor_.on_map(map, changed_slots, base_.T_world_base);
}

void Navigator::on_frame(const hal::Frame& frame, const hal::CameraModel& camera, const hal::PlanarPose& T_world_base,
                         TimeNs now) {
  floor_.on_frame(frame, camera, T_world_base, now);
}

void Navigator::meet(std::uint8_t flags, TimeNs now) {
  const bool left = (flags & hal::kobuki::kBumperLeft) != 0;
  const bool right = (flags & hal::kobuki::kBumperRight) != 0;
  if (left) floor_.on_touch(base_.T_world_base, kBumperSide_rad);
  if (right) floor_.on_touch(base_.T_world_base, -kBumperSide_rad);
  if ((flags & hal::kobuki::kBumperCentre) != 0) floor_.on_touch(base_.T_world_base, 0.0);
  if (mission_.is_driving()) {
    begin_trouble(Trouble::contact, StopReason::contact, (left ? 1.0 : 0.0) - (right ? 1.0 : 0.0), now);
  }
}

void Navigator::on_base(const BaseView& view, TimeNs now) {
  // Cliff sensors have the order of the bumper's bits: what is met there is not to be met again either.
  const auto met = static_cast<std::uint8_t>((view.bumper & ~base_.bumper) | (view.cliff & ~base_.cliff));
  base_ = view;
  report_.note_pose(view.T_world_base, now);
  if (!has_base_) {
    has_base_ = true;
    home_ = view.T_world_base;
    explorer_->set_home(home_);
    progress_.start(home_, now);
    last_step_ns_ = now;
  }
  floor_.on_pose(view.T_world_base, now);
  if (met != 0) meet(met, now);
  explorer_->set_energy_left(view.energy_left_s);
}

void Navigator::command(MissionEvent event) {
  using E = MissionEvent;
  if (event == E::come_home || event == E::battery_low) {
    is_sent_home_ = true;
    is_checking_ = false;
    explorer_->return_home();
    next_decision_ns_ = 0;
  } else if (event == E::resume) {
    retries_ = 0;
  } else if (event != E::pause && event != E::stop) {
    return;
  }
  mission_.apply(event);
}

bool Navigator::is_at_home() const { return distance_m(base_.T_world_base, home_) <= config_.home_tolerance_m; }

void Navigator::decide(TimeNs now) {
  decision_ = explorer_->decide(floor_.states(), floor_.cost(), floor_.changed_cells(), base_.T_world_base, now);
  floor_.forget_changes();
  report_.frontiers_left = decision_.left;
  next_decision_ns_ = after(now, config_.decide_period_s);
  if (decision_.kind == DecisionKind::go_home && look_at_closed_way(now)) return;
  if (decision_.kind != DecisionKind::look_around) mission_.apply(MissionEvent::looked_around);
  if (decision_.kind == DecisionKind::go_home) mission_.apply(MissionEvent::explored);
  const bool is_idle = !is_spinning_ && follower_.state() == FollowerState::idle;
  // A look around moves its goal's heading along with the robot: that is no other goal.
  const bool is_other = decision_.kind != followed_.kind || (!is_spinning_ && !(decision_.goal == followed_.goal));
  if (!decision_.is_new && !is_other && !is_idle && decision_.kind != DecisionKind::done) return;
  const bool is_left = !is_idle && decision_.kind == DecisionKind::goal && followed_.kind == DecisionKind::goal;
  const bool is_committed = is_left && left_goals_.change(followed_.goal, decision_.goal, now);
  follow_decision(now);
  if (is_committed && follower_.state() != FollowerState::idle) next_decision_ns_ = goal_until_ns_;
}

// Before it goes home: is what was closed still closed?
bool Navigator::look_at_closed_way(TimeNs now) {
  if (is_sent_home_ || mission_.state() != MissionState::exploring) return false;
  const bool is_anything_shut = decision_.left[LeftReason::unreachable] + decision_.left[LeftReason::blocked] > 0;
  if (!was_reopened_ && is_anything_shut && floor_.reopen()) {
    was_reopened_ = true;
    explore_again();
    next_decision_ns_ = now;
    return true;
  }
  while (ClosedWay* way = closed_ways_.next(floor_.cost(), base_.T_world_base)) {
    ++way->looks;
    checked_ = way->at;
    decision_.kind = DecisionKind::goal;
    decision_.goal = way->seen_from;
    is_checking_ = true;
    watch_until_ns_ = -1;
    follow_decision(now);
    if (is_checking_) return true;
  }
  return false;
}

void Navigator::watch_closed_way(TimeNs now) {
  const bool is_open = !ClosedWays::is_closed(checked_, floor_.cost());
  if (!is_open && (watch_until_ns_ < 0 || now < watch_until_ns_)) return;
  is_checking_ = false;
  if (is_open) explore_again();
  next_decision_ns_ = now;
}

void Navigator::explore_again() {
  ExplorerConfig config = sized(config_.explorer, floor_.states());
  config.look_around_first = false;
  explorer_ = std::make_unique<Explorer>(config);
  explorer_->set_home(home_);
  explorer_->set_energy_left(base_.energy_left_s);
  follower_.clear();
}

void Navigator::follow_decision(TimeNs now) {
  followed_ = decision_;
  is_spinning_ = false;
  switch (decision_.kind) {
    case DecisionKind::look_around:
      follower_.clear();
      is_spinning_ = true;
      spin_left_rad_ = decision_.turn_rad;
      spin_heading_rad_ = base_.T_world_base.heading_rad;
      return;
    case DecisionKind::done:
      return finish(now);
    case DecisionKind::goal:
    case DecisionKind::go_home:
      if (plan(now)) {
        goal_until_ns_ = after(now, follower_.track().length_m() / kSlowest_mps + kGoalGrace_s);
      }
  }
}

bool Navigator::plan(TimeNs now) {
  next_plan_ns_ = after(now, config_.plan_period_s);
  next_refresh_ns_ = after(now, config_.refresh_period_s);
  ++report_.paths_planned;
  Route route = planner_.plan(floor_.cost(), base_.T_world_base, decision_.goal, config_.goal_tolerance_m);
  const bool is_goal = decision_.kind == DecisionKind::goal;
  if (route.status == PathStatus::found) {
    goals_in_vain_ = 0;
  } else if (!is_goal || goals_in_vain_ >= kCutOff) {
    // It came that way: whoever stands there may be gone, and is seen from nearby.
    route = planner_.plan(floor_.cost_of_own_way(), base_.T_world_base, decision_.goal, config_.goal_tolerance_m);
  }
  if (route.status == PathStatus::found) {
    follower_.set_path(route.points, is_goal ? std::optional(decision_.goal.heading_rad) : std::nullopt);
    is_on_way_home_ = !is_goal;
    return true;
  }
  follower_.clear();
  is_hemmed_in_ = is_hemmed_in(floor_.cost(), base_.T_world_base);
  if (recovery_.is_active()) return false;
  if (is_hemmed_in_ || decision_.kind == DecisionKind::go_home) {
    begin_trouble(Trouble::no_path, StopReason::no_path, 0.0, now);
  } else {
    fail_goal(GoalFailure::no_path, now);
  }
  return false;
}

void Navigator::fail_goal(GoalFailure reason, TimeNs now) {
  if (!is_checking_) {
    ++report_.goals_failed;
    explorer_->goal_failed(reason);
    if (reason == GoalFailure::no_path) ++goals_in_vain_;
  }
  is_checking_ = false;
  follower_.clear();
  is_spinning_ = false;
  recovery_.end();
  // People walk away and maps grow: to try all goals within a second would give them all up for nothing.
  next_decision_ns_ = after(now, goals_in_vain_ > kCutOff ? kInVain_s : kAgain_s);
}

// Nothing is left to explore. Home is where it goes, even if the explorer has given that up.
void Navigator::finish(TimeNs now) {
  mission_.apply(MissionEvent::explored);
  if (is_at_home()) {
    follower_.clear();
    mission_.apply(MissionEvent::at_home);
    return;
  }
  if (follower_.state() != FollowerState::idle && is_on_way_home_) return;
  decision_.kind = DecisionKind::go_home;
  decision_.goal = home_;
  if (plan(now)) {
    goal_until_ns_ = after(now, follower_.track().length_m() / kSlowest_mps + kGoalGrace_s);
  } else if (recovery_.phase() == RecoveryPhase::idle && mission_.apply(MissionEvent::no_way_home)) {
    retry_ns_ = after(now, config_.retry_s);
  }
}

void Navigator::begin_trouble(Trouble trouble, StopReason reason, double side, TimeNs now) {
  report_.note_stop(reason);
  ++report_.recoveries;
  shut_since_ns_ = -1;
  follower_.clear();
  recovery_.start(trouble, side, recovery_view(now));
}

RecoveryView Navigator::recovery_view(TimeNs now) {
  behind_.gather(floor_.states(), base_.T_world_base, &floor_);
  free_behind_m_ = behind_.look(0.0, kBehind_m, true).free_m;
  return {now, base_.T_world_base, free_behind_m_, base_.bumper != 0};
}

hal::Twist Navigator::recover(TimeNs now) {
  const hal::Twist twist = recovery_.step(recovery_view(now));
  if (recovery_.phase() == RecoveryPhase::asking) {
    if (recovery_.trouble() == Trouble::shut && recovery_.attempts() > 0) floor_.close_suspects();
    if (is_spinning_ || plan(now)) {
      recovery_.answer(true, recovery_view(now));
    } else if (decision_.kind == DecisionKind::goal && !is_hemmed_in_) {
      fail_goal(GoalFailure::no_path, now);  // there may be other goals: no need to try everything for this one
    } else {
      recovery_.answer(false, recovery_view(now));
    }
  }
  if (recovery_.phase() == RecoveryPhase::gave_up) {
    fail_goal(GoalFailure::stuck, now);
    recovery_.reset();
    if (decision_.kind == DecisionKind::go_home && mission_.apply(MissionEvent::no_way_home)) {
      retry_ns_ = after(now, config_.retry_s);
    }
  }
  return twist;
}

hal::Twist Navigator::look_around(TimeNs now) {
  const double heading_rad = base_.T_world_base.heading_rad;
  spin_left_rad_ -= wrap_angle(heading_rad - spin_heading_rad_);
  spin_heading_rad_ = heading_rad;
  if (std::fabs(spin_left_rad_) > kSpun_rad && spin_left_rad_ * decision_.turn_rad > 0.0) {
    return {0.0, turn_rate_to(spin_left_rad_, config_.follower.limits)};
  }
  is_spinning_ = false;
  explorer_->goal_reached();
  next_decision_ns_ = now;
  return {};
}

hal::Twist Navigator::follow(TimeNs now) {
  const auto step_follower = [this] {
    return follower_.step(base_.T_world_base, base_.velocity, floor_.states(), floor_.cost(), &floor_);
  };
  hal::Twist twist = step_follower();
  if (follower_.state() == FollowerState::arrived) {
    follower_.clear();
    recovery_.reset();
    progress_.note_got_on(base_.T_world_base, now);
    if (is_checking_) {
      watch_until_ns_ = after(now, config_.closed_wait_s);
    } else {
      ++report_.goals_reached;
      explorer_->goal_reached();
      next_decision_ns_ = now;
    }
    return twist;
  }
  if (follower_.blocked_at_m())
    closed_ways_.note(follower_.track().ahead(*follower_.blocked_at_m()), base_.T_world_base);
  const bool is_worse = follower_.blocked_at_m() || follower_.is_shut() || follower_.track().offset_m() > kOffPath_m;
  if (now >= (is_worse ? next_plan_ns_ : next_refresh_ns_)) {
    if (!plan(now)) return {};
    twist = step_follower();
  }
  if (now >= goal_until_ns_) {
    fail_goal(GoalFailure::timeout, now);
    return {};
  }
  if (!follower_.is_shut()) {
    shut_since_ns_ = -1;
  } else if (shut_since_ns_ < 0) {
    shut_since_ns_ = now;
  } else if (now >= after(shut_since_ns_, config_.shut_s)) {
    begin_trouble(Trouble::shut, StopReason::shut, 0.0, now);
    // It has waited before: whatever stands there stays. Other goals may do as well.
    if (recovery_.attempts() > 0 && decision_.kind == DecisionKind::goal) {
      floor_.close_suspects();
      fail_goal(GoalFailure::stuck, now);
    }
  }
  return twist;
}

hal::Twist Navigator::drive(TimeNs now) {
  if (recovery_.is_active()) return recover(now);
  free_behind_m_ = 0.0;
  if (is_spinning_) return look_around(now);
  if (follower_.state() != FollowerState::idle) return follow(now);
  return {};
}

void Navigator::watch_progress(const hal::Twist& twist, TimeNs now) {
  progress_.step(twist, base_.T_world_base, now);
  if (recovery_.is_active()) progress_.note_moved(base_.T_world_base, now);
  if (is_spinning_) progress_.note_got_on(base_.T_world_base, now);
  if (progress_.is_stuck(now)) {
    progress_.note_moved(base_.T_world_base, now);
    push_against(twist, now);
  }
  if (progress_.is_lost(now) && mission_.apply(MissionEvent::lost)) retry_ns_ = after(now, config_.retry_s);
}

// The wheels work against something that presses no bumper: it is too high or too low for it.
void Navigator::push_against(const hal::Twist& twist, TimeNs now) {
  if (twist.forward_mps > 0.0) floor_.on_touch(base_.T_world_base, 0.0);
  begin_trouble(Trouble::no_progress, StopReason::no_progress, 0.0, now);
}

void Navigator::retry(TimeNs now) {
  if (mission_.state() != MissionState::needs_help || now < retry_ns_ || retries_ >= config_.max_retries) return;
  ++retries_;
  progress_.note_got_on(base_.T_world_base, now);
  floor_.forget_touches();
  mission_.apply(MissionEvent::resume);
  next_decision_ns_ = now;
}

// Whether it has to stand: the mission is held or over, or the safety table says so.
bool Navigator::stands_by(TimeNs now) {
  const bool is_forbidden = base_.verdict.state == hal::SafetyState::stand;
  const bool stands = !mission_.is_driving() || is_forbidden;
  if (stands && !is_standing_by_ && !mission_.is_over()) {
    report_.note_stop(is_forbidden ? StopReason::safety : StopReason::held);
    if (is_forbidden && base_.verdict.reason == hal::Condition::over_current) push_against(last_twist_, now);
  }
  if (!stands && is_standing_by_) next_refresh_ns_ = now;  // much may have changed meanwhile
  is_standing_by_ = stands;
  if (stands) {  // not held against any goal
    goal_until_ns_ += now - last_step_ns_;
    progress_.leave_out(now - last_step_ns_);
  }
  last_step_ns_ = now;
  return stands;
}

hal::Twist Navigator::step(TimeNs now) {
  if (!has_base_) return {};
  retry(now);
  if (stands_by(now)) return {};
  if (is_checking_) watch_closed_way(now);
  if (!is_checking_ && now >= next_decision_ns_ && !recovery_.is_active()) decide(now);
  if (!mission_.is_driving()) return {};
  last_twist_ = drive(now);
  watch_progress(last_twist_, now);
  return last_twist_;
}

}  // namespace g3d::nav
