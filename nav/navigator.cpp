// SPDX-License-Identifier: Apache-2.0
#include "nav/navigator.hpp"
#include "nav/seconds.hpp"

#include <algorithm>
#include <cmath>

#include "hal/kobuki/feedback.hpp"

namespace g3d::nav {
namespace {

constexpr double kBehind_m = 0.35;
constexpr double kGotAway_m = 0.3;
constexpr int kTrapped = 8;        // goals that failed in one place
constexpr double kAgain_s = 0.1;   // between decisions when one fails after the other,
constexpr double kInVain_s = 1.0;  // and when that goes on
constexpr int kCutOff = 3;         // goals in a row without a path: the robot is cut off from where it came from

double distance_m(const hal::PlanarPose& a, const hal::PlanarPose& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

ExplorerConfig sized(ExplorerConfig config, const CellGrid<CellState>& states) {
  config.max_cells = std::max(config.max_cells, static_cast<int>(states.cells.size()));
  return config;
}

RightOfWayConfig fitted(RightOfWayConfig config, const MotionLimits& limits) {
  config.body_radius_m = limits.body_radius_m;
  return config;
}

}  // namespace

Navigator::Navigator(const mapper::Grid& grid, const NavigatorConfig& config)
    : config_(config),
      floor_(grid, {config.ground, config.low_view, config.near_watch, config.frame_view,
                    config.follower.limits.body_radius_m, config.inflation_radius_m, config.inflation_decay_perm}),
      chooser_(config.make_chooser(sized(config.explorer, floor_.states()))),
      pursuit_(floor_.states(), config.follower, config.pursuit),
      behind_(config.follower.limits.body_radius_m, config.follower.limits.touch_margin_m, kBehind_m,
              floor_.states().resolution_m),
      recovery_(config.recovery),
      closed_way_(config.closed_wait_s),
      standby_(config.retry_s, config.max_retries),
      progress_(config.no_progress_s, config.lost_s),
      right_of_way_(fitted(config.right_of_way, config.follower.limits)),
      refuge_(floor_.states().resolution_m) {
  chooser_->prepare(floor_.states(), floor_.cost());
}

void Navigator::on_map_moving(const mapper::VoxelMap& map, std::span<const std::uint32_t> changed_slots) {
  if (!is_map_moving_) floor_.begin_to_move();
  is_map_moving_ = true;
  last_twist_ = {};
  if (!changed_slots.empty()) floor_.on_map(map, changed_slots, base_.T_world_base);
}

// Where it stands in the corrected map the next packet says.
void Navigator::on_map_moved(const mapper::submaps::ChainMove& move, TimeNs now) {
  is_map_moving_ = false;
  floor_.move(move);
  base_.T_world_base = compose(on_plane(move.newest()), base_.T_world_base);
  home_ = compose(on_plane(move.at(home_ns_)), home_);
  chooser_->set_home(home_);
  chooser_->map_moved();
  closed_way_.end();
  pursuit_.clear();
  spin_.clear();
  recovery_.reset();
  progress_.note_got_on(base_.T_world_base, now);
  is_deciding_ = false;
  next_decision_ns_ = now;
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
  if (is_map_moving_) {  // what is touched meanwhile is noticed afterwards, if it is touched still
    const std::uint8_t bumper = base_.bumper & view.bumper;
    const std::uint8_t cliff = base_.cliff & view.cliff;
    base_ = view;
    base_.bumper = bumper;
    base_.cliff = cliff;
    return;
  }
  // Cliff sensors have the order of the bumper's bits: what is met there is not to be met again either.
  const auto met = static_cast<std::uint8_t>((view.bumper & ~base_.bumper) | (view.cliff & ~base_.cliff));
  base_ = view;
  report_.note_pose(view.T_world_base, now);
  if (!has_base_) {
    has_base_ = true;
    home_ = view.T_world_base;
    home_ns_ = now;
    chooser_->set_home(home_);
    progress_.start(home_, now);
    standby_.start(now);
  }
  floor_.on_pose(view.T_world_base, now);
  if (met != 0) meet(met, now);
  chooser_->set_energy_left(view.energy_left_s);
}

void Navigator::command(MissionEvent event) {
  using E = MissionEvent;
  if (event == E::come_home || event == E::battery_low) {
    is_sent_home_ = true;
    closed_way_.end();
    chooser_->return_home(event == E::battery_low);
    next_decision_ns_ = 0;
  } else if (event == E::resume) {
    standby_.forget_retries();
  } else if (event != E::pause && event != E::stop) {
    return;
  }
  mission_.apply(event);
}

bool Navigator::is_at_home() const { return distance_m(base_.T_world_base, home_) <= config_.home_tolerance_m; }

void Navigator::decide(TimeNs now) {
  if (!is_deciding_) decision_begun_ns_ = now;
  const auto made = chooser_->decide(floor_.states(), floor_.cost(), floor_.changed_cells(), base_.T_world_base, now);
  floor_.forget_changes();
  is_deciding_ = !made;
  if (!made) return;
  decision_ = *made;
  report_.frontiers_left = decision_.left;
  next_decision_ns_ = after(decision_begun_ns_, config_.decide_period_s);
  if (decision_.kind == DecisionKind::go_home && look_at_closed_way(now)) return;
  if (decision_.kind != DecisionKind::look_around) mission_.apply(MissionEvent::looked_around);
  if (decision_.kind == DecisionKind::go_home) mission_.apply(MissionEvent::explored);
  if (decision_.kind == DecisionKind::goal) mission_.apply(MissionEvent::more_to_see);
  const bool is_idle = !spin_.is_active() && pursuit_.is_idle();
  // A look around moves its goal's heading along with the robot: that is no other goal.
  const bool is_other = decision_.kind != followed_.kind || (!spin_.is_active() && !(decision_.goal == followed_.goal));
  if (!decision_.is_new && !is_other && !is_idle && decision_.kind != DecisionKind::done) return;
  const bool is_left =
      config_.is_steadfast && !is_idle && decision_.kind == DecisionKind::goal && followed_.kind == DecisionKind::goal;
  const bool is_committed = is_left && left_goals_.change(followed_.goal, decision_.goal, now);
  follow_decision(now);
  if (is_committed && !pursuit_.is_idle()) next_decision_ns_ = pursuit_.goal_until_ns();
}

// Before it goes home: is what was closed still closed?
bool Navigator::look_at_closed_way(TimeNs now) {
  if (is_sent_home_ || mission_.state() != MissionState::exploring) return false;
  const bool is_anything_shut = decision_.left[LeftReason::unreachable] + decision_.left[LeftReason::blocked] > 0;
  const bool is_reopened = !was_reopened_ && is_anything_shut && floor_.reopen();
  was_reopened_ = was_reopened_ || is_reopened;
  if (is_reopened || (is_anything_shut && floor_.trust_own_way())) {
    explore_again();
    next_decision_ns_ = now;
    return true;
  }
  while (const auto seen_from = closed_way_.begin(floor_.cost(), base_.T_world_base)) {
    decision_.kind = DecisionKind::goal;
    decision_.goal = *seen_from;
    follow_decision(now);
    if (closed_way_.is_active()) return true;
  }
  return false;
}

void Navigator::judge_closed_way(ClosedWayCheck::Finding finding, TimeNs now) {
  if (finding == ClosedWayCheck::Finding::open_now) explore_again();
  next_decision_ns_ = now;
}

void Navigator::explore_again() {
  chooser_->start_again();
  pursuit_.clear();
}

void Navigator::follow_decision(TimeNs now) {
  followed_ = decision_;
  spin_.clear();
  switch (decision_.kind) {
    case DecisionKind::look_around:
      pursuit_.clear();
      return spin_.start(decision_.turn_rad, base_.T_world_base.heading_rad);
    case DecisionKind::done:
      return finish(now);
    case DecisionKind::goal:
    case DecisionKind::go_home:
      if (plan(now)) pursuit_.allow_time(now);
  }
}

bool Navigator::plan(TimeNs now) {
  ++report_.paths_planned;
  is_making_room_ = false;
  const bool is_goal = decision_.kind == DecisionKind::goal;
  const bool may_retrace = !is_goal || goals_in_vain_ >= kCutOff;
  const Way way = pursuit_.plan(floor_, base_.T_world_base, decision_.goal, is_goal, may_retrace, now);
  if (way == Way::open) goals_in_vain_ = 0;
  if (way != Way::none) return true;
  if (recovery_.is_active()) return false;
  if (pursuit_.is_hemmed_in() || decision_.kind == DecisionKind::go_home) {
    begin_trouble(Trouble::no_path, StopReason::no_path, 0.0, now);
  } else {
    fail_goal(GoalFailure::no_path, now);
  }
  return false;
}

// Goal after goal fails, and the robot has not got away from here: then it is not the goals. What it believes to have
// touched may be wrong, and would have it give up the whole building.
void Navigator::note_failed_here() {
  const hal::PlanarPose& here = base_.T_world_base;
  if (std::hypot(here.x_m - failed_at_.x_m, here.y_m - failed_at_.y_m) > kGotAway_m) {
    failed_at_ = here;
    failed_here_ = 0;
  }
  if (++failed_here_ % kTrapped == 0) floor_.forget_touches();
}

void Navigator::fail_goal(GoalFailure reason, TimeNs now) {
  note_failed_here();
  if (!closed_way_.is_active()) {
    ++report_.goals_failed;
    chooser_->goal_failed(reason);
    if (reason == GoalFailure::no_path) ++goals_in_vain_;
  }
  closed_way_.end();
  pursuit_.clear();
  spin_.clear();
  recovery_.end();
  // People walk away and maps grow: to try all goals within a second would give them all up for nothing.
  next_decision_ns_ = after(now, goals_in_vain_ > kCutOff ? kInVain_s : kAgain_s);
}

// Nothing is left to explore. Home is where it goes, even if the chooser has given that up.
void Navigator::finish(TimeNs now) {
  mission_.apply(MissionEvent::explored);
  if (is_at_home()) {
    pursuit_.clear();
    mission_.apply(MissionEvent::at_home);
    return;
  }
  if (!pursuit_.is_idle() && pursuit_.takes_any_heading()) return;  // on the way home
  decision_.kind = DecisionKind::go_home;
  decision_.goal = home_;
  if (plan(now)) {
    pursuit_.allow_time(now);
  } else if (recovery_.phase() == RecoveryPhase::idle && mission_.apply(MissionEvent::no_way_home)) {
    standby_.call_for_help(now);
  }
}

void Navigator::begin_trouble(Trouble trouble, StopReason reason, double side, TimeNs now) {
  report_.note_stop(reason);
  ++report_.recoveries;
  pursuit_.forget_shut();
  pursuit_.clear();
  recovery_.start(trouble, side, recovery_view(now));
}

RecoveryView Navigator::recovery_view(TimeNs now) {
  behind_.gather(floor_.states(), base_.T_world_base, &floor_);
  free_behind_m_ = behind_.look(0.0, kBehind_m, true, true).free_m;
  return {now, base_.T_world_base, free_behind_m_, base_.bumper != 0};
}

hal::Twist Navigator::recover(TimeNs now) {
  const hal::Twist twist = recovery_.step(recovery_view(now));
  if (recovery_.phase() == RecoveryPhase::asking) {
    if (recovery_.trouble() == Trouble::shut && recovery_.attempts() > 0) floor_.close_suspects();
    if (spin_.is_active() || plan(now)) {
      recovery_.answer(true, recovery_view(now));
    } else if (decision_.kind == DecisionKind::goal && !pursuit_.is_hemmed_in()) {
      fail_goal(GoalFailure::no_path, now);  // there may be other goals: no need to try everything for this one
    } else {
      recovery_.answer(false, recovery_view(now));
    }
  }
  if (recovery_.phase() == RecoveryPhase::gave_up) {
    fail_goal(GoalFailure::stuck, now);
    recovery_.reset();
    if (decision_.kind == DecisionKind::go_home && mission_.apply(MissionEvent::no_way_home)) {
      standby_.call_for_help(now);
    }
  }
  return twist;
}

hal::Twist Navigator::look_around(TimeNs now) {
  if (const auto twist = spin_.step(base_.T_world_base.heading_rad, config_.follower.limits)) return *twist;
  chooser_->goal_reached();
  next_decision_ns_ = now;
  return {};
}

void Navigator::arrive(TimeNs now) {
  pursuit_.clear();
  recovery_.reset();
  progress_.note_got_on(base_.T_world_base, now);
  if (closed_way_.is_active()) return closed_way_.watch(now);
  ++report_.goals_reached;
  chooser_->goal_reached();
  next_decision_ns_ = now;
}

hal::Twist Navigator::follow(TimeNs now) {
  hal::Twist twist = pursuit_.step(floor_, base_.T_world_base, base_.velocity);
  if (is_making_room_) return make_room(twist, now);
  if (pursuit_.has_arrived()) {
    arrive(now);
    return twist;
  }
  const auto closed_at = pursuit_.closed_at();
  if (closed_at && ClosedWays::is_closed(*closed_at, floor_.cost())) closed_way_.note(*closed_at, base_.T_world_base);
  if (pursuit_.wants_path(now)) {
    if (!plan(now)) return {};
    twist = pursuit_.step(floor_, base_.T_world_base, base_.velocity);
  }
  if (pursuit_.is_late(now)) {
    fail_goal(GoalFailure::timeout, now);
    return {};
  }
  twist = give_way(twist, now);
  if (pursuit_.is_shut_for_long(now)) {
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
  if (spin_.is_active()) return look_around(now);
  if (!pursuit_.is_idle()) return follow(now);
  return {};
}

void Navigator::watch_progress(const hal::Twist& twist, TimeNs now) {
  progress_.step(twist, base_.T_world_base, now);
  if (recovery_.is_active()) progress_.note_moved(base_.T_world_base, now);
  if (spin_.is_active()) progress_.note_got_on(base_.T_world_base, now);
  if (progress_.is_stuck(now)) {
    progress_.note_moved(base_.T_world_base, now);
    push_against(twist, now);
  }
  if (progress_.is_lost(now) && mission_.apply(MissionEvent::lost)) standby_.call_for_help(now);
}

// The wheels work against something that presses no bumper: it is too high or too low for it. If one is pressed, that
// is what holds the robot, and nothing need stand ahead.
void Navigator::push_against(const hal::Twist& twist, TimeNs now) {
  if (twist.forward_mps > 0.0 && base_.bumper == 0) floor_.on_touch(base_.T_world_base, 0.0);
  begin_trouble(Trouble::no_progress, StopReason::no_progress, 0.0, now);
}

hal::Twist Navigator::step(TimeNs now) {
  if (!has_base_ || is_map_moving_) return {};
  retry(now);
  if (stands_by(now)) return {};
  if (closed_way_.is_active()) {
    if (const auto finding = closed_way_.step(floor_.cost(), now)) judge_closed_way(*finding, now);
  }
  if (!closed_way_.is_active() && now >= next_decision_ns_ && !recovery_.is_active() && !is_making_room()) {
    decide(now);
  } else {
    chooser_->work_ahead(floor_.states(), floor_.cost(), floor_.changed_cells());
    floor_.forget_changes();
  }
  if (!mission_.is_driving()) return {};
  last_twist_ = drive(now);
  watch_progress(last_twist_, now);
  return last_twist_;
}

}  // namespace g3d::nav
