// SPDX-License-Identifier: Apache-2.0
#include "nav/navigator.hpp"

#include <algorithm>
#include <cmath>

#include "hal/kobuki/feedback.hpp"

namespace g3d::nav {
namespace {

constexpr double kTouchRadius_m = 0.05;
constexpr double kBehind_m = 0.35;
constexpr double kMoves_m = 0.05;    // less than this, or
constexpr double kMoves_rad = 0.15;  // than this, is no progress
constexpr double kGotOn_m = 0.5;
constexpr double kOffPath_m = 0.35;    // farther from the path: another one is better
constexpr double kSlowest_mps = 0.12;  // on average, until a goal takes too long
constexpr double kGoalGrace_s = 25.0;
constexpr double kSpun_rad = 0.05;
constexpr double kAgain_s = 0.1;                // between decisions when one fails after the other
constexpr std::uint32_t kHemmedIn_cells = 400;  // reached no more than this: it is the robot that is shut in

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

double planning_radius_m(double body_radius_m, double cell_m) { return body_radius_m + 0.7 * cell_m; }

Navigator::Navigator(const mapper::Grid& grid, const NavigatorConfig& config)
    : config_(config),
      ground_(grid, config.ground),
      inflation_(ground_.states(), {planning_radius_m(config.follower.limits.body_radius_m, ground_.resolution_m()),
                                    config.inflation_radius_m, config.inflation_decay_perm}),
      explorer_(sized(config.explorer, ground_.states())),
      planner_(ground_.states().cells.size()),
      follower_(fitted(config.follower, ground_.resolution_m())),
      behind_(config.follower.limits.body_radius_m, config.follower.limits.touch_margin_m, kBehind_m,
              ground_.resolution_m()),
      recovery_(config.recovery),
      trace_(ground_.states(), config.follower.limits.body_radius_m),
      low_view_(ground_.states(), config.low_view),
      near_watch_(ground_.states(), config.near_watch),
      is_noted_(ground_.states().cells.size()) {
  changed_.reserve(is_noted_.size());
}

bool Navigator::is_seen(Cell c) const {
  return ground_.is_floor_seen(c) || trace_.is_trodden(c) || low_view_.is_seen(c);
}

void Navigator::note_changed(std::span<const std::uint32_t> cells) {
  for (const std::uint32_t cell : cells) {
    if (is_noted_[cell] != 0) continue;
    is_noted_[cell] = 1;
    changed_.push_back(cell);
  }
}

void Navigator::take_over_changes() {
  const std::span<const std::uint32_t> fresh = ground_.changed_cells().subspan(taken_over_);
  taken_over_ = ground_.changed_cells().size();
  if (fresh.empty()) return;
  inflation_.update(ground_.states(), fresh);
  note_changed(fresh);
  note_changed(inflation_.changed_cells());
}

void Navigator::on_map(const mapper::VoxelMap& map, std::span<const std::uint32_t> changed_slots, TimeNs) {
  take_over_changes();  // marks since the last frame
  ground_.update(map, changed_slots);
  taken_over_ = 0;
  take_over_changes();
  if (has_base_) low_view_.look(ground_.states(), base_.T_world_base);
}

void Navigator::on_frame(const hal::Frame& frame, const hal::CameraModel& camera, const hal::PlanarPose& T_world_base,
                         TimeNs now) {
  near_watch_.look(frame, camera, ground_.states(), T_world_base, now);
}

void Navigator::meet(std::uint8_t flags, TimeNs now) {
  const bool left = (flags & hal::kobuki::kBumperLeft) != 0;
  const bool right = (flags & hal::kobuki::kBumperRight) != 0;
  const auto mark = [this](double side_rad) {
    const Waypoint touched = where_touched(ground_.states(), base_.T_world_base, side_rad, body_radius_m());
    ground_.mark_contact(touched.x_m, touched.y_m, kTouchRadius_m);
  };
  if (left) mark(kBumperSide_rad);
  if (right) mark(-kBumperSide_rad);
  if ((flags & hal::kobuki::kBumperCentre) != 0) mark(0.0);
  take_over_changes();
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
    explorer_.set_home(home_);
    watched_pose_ = got_on_pose_ = home_;
    watched_ns_ = got_on_ns_ = now;
  }
  if (trace_.tread(view.T_world_base)) {
    ground_.mark_free_disc(view.T_world_base.x_m, view.T_world_base.y_m, body_radius_m());
    take_over_changes();
  }
  if (met != 0) meet(met, now);
  explorer_.set_energy_left(view.energy_left_s);
}

void Navigator::command(MissionEvent event) {
  switch (event) {
    case MissionEvent::come_home:
    case MissionEvent::battery_low:
      explorer_.return_home();
      next_decision_ns_ = 0;
      break;
    case MissionEvent::resume:
      retries_ = 0;
      break;
    case MissionEvent::pause:
    case MissionEvent::stop:
      break;
    default:
      return;
  }
  mission_.apply(event);
}

bool Navigator::is_at_home() const { return distance_m(base_.T_world_base, home_) <= config_.home_tolerance_m; }

// --- Deciding -------------------------------------------------------------------------------------------------------

void Navigator::decide(TimeNs now) {
  decision_ = explorer_.decide(ground_.states(), inflation_.cost(), changed_, base_.T_world_base, now);
  for (const std::uint32_t cell : changed_) is_noted_[cell] = 0;
  changed_.clear();
  report_.frontiers_left = decision_.left;
  next_decision_ns_ = after(now, config_.decide_period_s);
  const bool is_other = decision_.kind != followed_.kind || !(decision_.goal == followed_.goal);
  if (decision_.kind != DecisionKind::look_around) mission_.apply(MissionEvent::looked_around);
  if (decision_.kind == DecisionKind::go_home) mission_.apply(MissionEvent::explored);
  const bool is_idle = !is_spinning_ && follower_.state() == FollowerState::idle;
  // A look around moves its goal's heading along with the robot: only a new one counts.
  const bool is_changed = decision_.kind == DecisionKind::look_around ? !is_spinning_ : is_other;
  if (decision_.is_new || is_changed || is_idle || decision_.kind == DecisionKind::done) follow_decision(now);
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
  const Route route = planner_.plan(inflation_.cost(), base_.T_world_base, decision_.goal, config_.goal_tolerance_m);
  if (route.status == PathStatus::found) {
    const bool is_goal = decision_.kind == DecisionKind::goal;
    follower_.set_path(route.points, is_goal ? std::optional(decision_.goal.heading_rad) : std::nullopt);
    is_on_way_home_ = !is_goal;
    return true;
  }
  follower_.clear();
  is_hemmed_in_ = route.status == PathStatus::unreachable && route.expansions < kHemmedIn_cells;
  if (recovery_.is_active()) return false;
  if (is_hemmed_in_ || decision_.kind == DecisionKind::go_home) {
    begin_trouble(Trouble::no_path, StopReason::no_path, 0.0, now);
  } else {
    fail_goal(GoalFailure::no_path, now);
  }
  return false;
}

void Navigator::fail_goal(GoalFailure reason, TimeNs now) {
  ++report_.goals_failed;
  explorer_.goal_failed(reason);
  follower_.clear();
  is_spinning_ = false;
  recovery_.end();
  next_decision_ns_ = after(now, kAgain_s);
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

// --- Driving --------------------------------------------------------------------------------------------------------

void Navigator::begin_trouble(Trouble trouble, StopReason reason, double side, TimeNs now) {
  report_.note_stop(reason);
  ++report_.recoveries;
  shut_since_ns_ = -1;
  follower_.clear();
  recovery_.start(trouble, side, recovery_view(now));
}

RecoveryView Navigator::recovery_view(TimeNs now) {
  behind_.gather(ground_.states(), base_.T_world_base, this);
  free_behind_m_ = behind_.look(0.0, kBehind_m, true).free_m;
  return {now, base_.T_world_base, free_behind_m_, base_.bumper != 0};
}

hal::Twist Navigator::recover(TimeNs now) {
  const hal::Twist twist = recovery_.step(recovery_view(now));
  if (recovery_.phase() == RecoveryPhase::asking) {
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
  watched_ns_ = now;
  watched_pose_ = base_.T_world_base;
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
  explorer_.goal_reached();
  next_decision_ns_ = now;
  return {};
}

hal::Twist Navigator::follow(TimeNs now) {
  const auto step_follower = [this] {
    return follower_.step(base_.T_world_base, base_.velocity, ground_.states(), inflation_.cost(), this);
  };
  hal::Twist twist = step_follower();
  if (follower_.state() == FollowerState::arrived) {
    ++report_.goals_reached;
    follower_.clear();
    explorer_.goal_reached();
    recovery_.reset();
    got_on_ns_ = now;
    next_decision_ns_ = now;
    return twist;
  }
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
  const hal::PlanarPose& pose = base_.T_world_base;
  const bool should_move = std::fabs(twist.forward_mps) > 0.03 || std::fabs(twist.turn_radps) > 0.1;
  const bool moves = distance_m(pose, watched_pose_) > kMoves_m ||
                     std::fabs(wrap_angle(pose.heading_rad - watched_pose_.heading_rad)) > kMoves_rad;
  if (!should_move || moves) {
    watched_ns_ = now;
    watched_pose_ = pose;
  } else if (now >= after(watched_ns_, config_.no_progress_s)) {
    begin_trouble(Trouble::no_progress, StopReason::no_progress, 0.0, now);
    watched_ns_ = now;
  }
  if (distance_m(pose, got_on_pose_) > kGotOn_m || is_spinning_) {
    got_on_pose_ = pose;
    got_on_ns_ = now;
  } else if (now >= after(got_on_ns_, config_.lost_s) && mission_.apply(MissionEvent::lost)) {
    retry_ns_ = after(now, config_.retry_s);
  }
}

void Navigator::retry(TimeNs now) {
  if (mission_.state() != MissionState::needs_help || now < retry_ns_ || retries_ >= config_.max_retries) return;
  ++retries_;
  got_on_ns_ = now;
  ground_.forget_contacts();
  take_over_changes();
  mission_.apply(MissionEvent::resume);
  next_decision_ns_ = now;
}

// Whether it has to stand: the mission is held or over, or the safety table says so.
bool Navigator::stands_by(TimeNs now) {
  const bool is_forbidden = base_.verdict.state == hal::SafetyState::stand;
  const bool stands = !mission_.is_driving() || is_forbidden;
  if (stands && !is_standing_by_ && !mission_.is_over()) {
    report_.note_stop(is_forbidden ? StopReason::safety : StopReason::held);
  }
  if (!stands && is_standing_by_) next_refresh_ns_ = now;  // much may have changed meanwhile
  is_standing_by_ = stands;
  if (stands) {
    // Time that it had to stand is not held against any goal.
    const TimeNs stood_ns = now - watched_ns_;
    goal_until_ns_ += stood_ns;
    got_on_ns_ += stood_ns;
    watched_ns_ = now;
  }
  return stands;
}

hal::Twist Navigator::step(TimeNs now) {
  if (!has_base_) return {};
  now_ns_ = now;
  retry(now);
  if (stands_by(now)) return {};
  if (now >= next_decision_ns_ && !recovery_.is_active()) decide(now);
  if (!mission_.is_driving()) return {};
  const hal::Twist twist = drive(now);
  watch_progress(twist, now);
  return twist;
}

}  // namespace g3d::nav
