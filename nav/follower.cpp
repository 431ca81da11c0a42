// SPDX-License-Identifier: Apache-2.0
#include "nav/follower.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace g3d::nav {
namespace {

// Points ahead that arcs are tried to: far ones drive fast and smooth, near ones stay on the path.
constexpr std::array kLookahead_m{0.70, 0.50, 0.35, 0.22, 0.14};
constexpr double kBetter = 1.05;         // a nearer point must allow this much more speed
constexpr double kTurnFrom_rad = 1.0;    // path this far to the side: turn on the spot,
constexpr double kTurnUntil_rad = 0.35;  // until so near; the rest is turned while driving
constexpr double kBearing_m = 0.35;      // where the path leads to
constexpr double kInView_rad = 0.4;      // half of the camera's 57 degrees, less some
constexpr double kFaced_rad = 0.12;      // no use to turn any nearer to what does not let through
constexpr double kHalfTurn_rad = 2.6;    // left or right is undecided beyond
constexpr double kStanding_mps = 0.12;   // slow enough to begin a turn on the spot
constexpr double kTooSlow_mps = 0.02;
constexpr double kGoalReaction_s = 0.08;  // the end of a path is no danger: brake late
constexpr double kPathSample_m = 0.05;

double reach_of(const MotionLimits& limits) {
  return distance_to_stop(limits.max_speed_mps, limits.deceleration_mps2, limits.reaction_s) + 2 * ArcCheck::kStep_m;
}

}  // namespace

Follower::Follower(const FollowerConfig& config)
    : config_(config),
      check_(config.limits.body_radius_m, config.limits.touch_margin_m, reach_of(config.limits), config.resolution_m) {}

void Follower::set_path(std::span<const Waypoint> path, std::optional<double> final_heading_rad) {
  track_.set(path);
  final_heading_rad_ = final_heading_rad;
  blocked_at_m_.reset();
  is_shut_ = false;
  at_end_ = track_.empty();
  if (at_end_ && !final_heading_rad_) return clear();
  state_ = FollowerState::driving;
}

void Follower::clear() {
  track_.clear();
  final_heading_rad_.reset();
  blocked_at_m_.reset();
  is_shut_ = false;
  at_end_ = false;
  is_turning_to_path_ = false;
  limiter_ = SpeedLimiter::none;
  state_ = FollowerState::idle;
}

hal::Twist Follower::step(const hal::PlanarPose& T_world_base, const hal::Twist& velocity,
                          const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost,
                          const FloorKnowledge* floor) {
  limiter_ = SpeedLimiter::none;
  is_shut_ = false;
  check_.gather(ground, T_world_base, floor);
  if (state_ == FollowerState::idle || state_ == FollowerState::arrived) return {};
  if (!at_end_) {
    track_.advance(T_world_base.x_m, T_world_base.y_m);
    const Waypoint end = track_.points().back();
    const double to_end_m = std::hypot(end.x_m - T_world_base.x_m, end.y_m - T_world_base.y_m);
    at_end_ = to_end_m <= config_.goal_tolerance_m && track_.remaining_m() <= 2.0 * config_.goal_tolerance_m;
  }
  if (at_end_) return align(T_world_base, velocity);

  look_along_path(T_world_base, cost);
  const double bearing = bearing_rad(T_world_base, kBearing_m);
  is_turning_to_path_ = std::fabs(bearing) > (is_turning_to_path_ ? kTurnUntil_rad : kTurnFrom_rad);
  if (is_turning_to_path_) {
    state_ = FollowerState::turning;
    return turn(bearing, velocity);
  }
  turn_sign_ = 0.0;
  Choice choice = choose_arc(T_world_base, false);
  limiter_ = choice.limiter;
  // Before it creeps where nobody has looked, the path must be in view; where no arc goes on, a straight one may.
  const bool is_blind = choice.limiter == SpeedLimiter::unknown && choice.speed_mps <= config_.limits.crawl_speed_mps;
  // Nor does it drive along where the camera has not looked for a while, when somebody may have come there.
  if ((is_blind && std::fabs(bearing) > kInView_rad) ||
      (choice.leads_unwatched && std::fabs(bearing) > kTurnUntil_rad)) {
    is_turning_to_path_ = std::fabs(bearing) > kTurnUntil_rad;
    state_ = FollowerState::turning;
    return turn(bearing, velocity);
  }
  if (choice.speed_mps < kTooSlow_mps) {
    const double near_rad = bearing_rad(T_world_base, kLookahead_m.back());
    if (std::fabs(near_rad) > kFaced_rad) {
      state_ = FollowerState::turning;
      return turn(near_rad, velocity);
    }
    // Where it has been it may be again, and creeps between what the map's noise may have put beside that way.
    choice = choose_arc(T_world_base, true);
    limiter_ = choice.limiter;
  }
  state_ = FollowerState::driving;
  if (choice.speed_mps < kTooSlow_mps) {
    is_shut_ = true;
    return {};
  }
  return {choice.speed_mps, choice.speed_mps * choice.curvature_per_m};
}

double Follower::bearing_rad(const hal::PlanarPose& T_world_base, double ahead_m) const {
  const Waypoint point = track_.ahead(ahead_m);
  const double dx = point.x_m - T_world_base.x_m;
  const double dy = point.y_m - T_world_base.y_m;
  return wrap_angle(std::atan2(dy, dx) - T_world_base.heading_rad);
}

Follower::Choice Follower::choose_arc(const hal::PlanarPose& T_world_base, bool trusts_own_way) const {
  const MotionLimits& limits = config_.limits;
  const double forward_x = std::cos(T_world_base.heading_rad);
  const double forward_y = std::sin(T_world_base.heading_rad);
  Choice best;
  best.limiter = SpeedLimiter::obstacle;
  double last_distance_m = -1.0;
  for (const double ahead_m : kLookahead_m) {
    const Waypoint point = track_.ahead(ahead_m);
    const double dx = point.x_m - T_world_base.x_m;
    const double dy = point.y_m - T_world_base.y_m;
    const double forward_m = dx * forward_x + dy * forward_y;
    const double left_m = dy * forward_x - dx * forward_y;
    const double square_m2 = dx * dx + dy * dy;
    if (forward_m <= 0.0 || square_m2 == last_distance_m) continue;
    last_distance_m = square_m2;
    const Choice choice = allowed(2.0 * left_m / square_m2, trusts_own_way);  // pure pursuit: the circle through both
    if (choice.speed_mps > best.speed_mps * kBetter + 1e-3) best = choice;
  }
  const double brake_mps = speed_to_stop_within(track_.remaining_m(), limits.deceleration_mps2, kGoalReaction_s);
  if (brake_mps < best.speed_mps) {
    best.speed_mps = std::max(brake_mps, kTooSlow_mps);
    best.limiter = SpeedLimiter::goal;
  }
  return best;
}

Follower::Choice Follower::allowed(double curvature_per_m, bool trusts_own_way) const {
  const MotionLimits& limits = config_.limits;
  Choice choice{limits.max_speed_mps, curvature_per_m, SpeedLimiter::none};
  const auto limit = [&choice](double speed_mps, SpeedLimiter limiter) {
    if (speed_mps >= choice.speed_mps) return;
    choice.speed_mps = std::max(speed_mps, 0.0);
    choice.limiter = limiter;
  };
  if (curvature_per_m != 0.0) limit(limits.max_turn_radps / std::fabs(curvature_per_m), SpeedLimiter::curvature);
  const double reach_m = distance_to_stop(choice.speed_mps, limits.deceleration_mps2, limits.reaction_s);
  const ArcView view = check_.look(curvature_per_m, reach_m + ArcCheck::kStep_m, false, trusts_own_way);
  const double beside = std::clamp(view.clearance_m / ArcCheck::kNoticed_m, 0.0, 1.0);
  limit(config_.beside_obstacle_mps + beside * (limits.max_speed_mps - config_.beside_obstacle_mps),
        SpeedLimiter::clearance);
  const auto stop_within = [&limits](double distance_m) {
    return speed_to_stop_within(distance_m, limits.deceleration_mps2, limits.reaction_s);
  };
  // The path was planned there, so what is still unknown may be crept up to and over; what is occupied may not.
  limit(std::max(stop_within(view.free_m), limits.crawl_speed_mps),
        view.is_doubtful ? SpeedLimiter::unknown : SpeedLimiter::tight);
  limit(trusts_own_way ? std::min(stop_within(view.clear_m), limits.crawl_speed_mps) : stop_within(view.clear_m),
        SpeedLimiter::obstacle);
  choice.leads_unwatched =
      view.watched_m < distance_to_stop(choice.speed_mps, limits.deceleration_mps2, limits.reaction_s);
  return choice;
}

void Follower::look_along_path(const hal::PlanarPose& T_world_base, const CellGrid<std::uint8_t>& cost) {
  blocked_at_m_.reset();
  const auto is_shut_at = [&cost](double x_m, double y_m) {
    const Cell c = cost.cell_of(x_m, y_m);
    return cost.contains(c) && cost.at(c) >= kInscribedCost && cost.at(c) != kUnknownCost;
  };
  // From a place where it should not be, the robot leaves over cells where it should not be.
  const double from_m = is_shut_at(T_world_base.x_m, T_world_base.y_m) ? 2.0 * config_.limits.body_radius_m : 0.0;
  const double until_m = std::min(config_.path_look_m, track_.remaining_m());
  for (double s = from_m; s <= until_m; s += kPathSample_m) {
    const Waypoint point = track_.ahead(s);
    if (!is_shut_at(point.x_m, point.y_m)) continue;
    blocked_at_m_ = s;
    return;
  }
}

hal::Twist Follower::turn(double error_rad, const hal::Twist& velocity) {
  if (std::fabs(velocity.forward_mps) > kStanding_mps) return {};  // brake along the arc that was found free
  if (std::fabs(error_rad) > kHalfTurn_rad && turn_sign_ != 0.0) {
    return {0.0, turn_sign_ * config_.limits.max_turn_radps};
  }
  const double rate_radps = turn_rate_to(error_rad, config_.limits);
  turn_sign_ = std::copysign(1.0, rate_radps);
  return {0.0, rate_radps};
}

hal::Twist Follower::align(const hal::PlanarPose& T_world_base, const hal::Twist& velocity) {
  if (!final_heading_rad_) {
    state_ = FollowerState::arrived;
    return {};
  }
  const double error_rad = wrap_angle(*final_heading_rad_ - T_world_base.heading_rad);
  if (std::fabs(error_rad) <= config_.heading_tolerance_rad) {
    state_ = FollowerState::arrived;
    return {};
  }
  state_ = FollowerState::aligning;
  return turn(error_rad, velocity);
}

}  // namespace g3d::nav
