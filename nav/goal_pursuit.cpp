// SPDX-License-Identifier: Apache-2.0
#include "nav/goal_pursuit.hpp"
#include "nav/seconds.hpp"

namespace g3d::nav {
namespace {

constexpr double kOffPath_m = 0.35;    // farther from the path: another one is better
constexpr double kSlowest_mps = 0.12;  // on average, until a goal takes too long
constexpr double kGoalGrace_s = 25.0;

FollowerConfig fitted(FollowerConfig config, double resolution_m) {
  config.resolution_m = resolution_m;
  return config;
}

}  // namespace

GoalPursuit::GoalPursuit(const CellGrid<CellState>& states, const FollowerConfig& follower, const PursuitConfig& config)
    : config_(config), planner_(states.cells.size()), follower_(fitted(follower, states.resolution_m)) {}

Way GoalPursuit::plan(Surroundings& floor, const hal::PlanarPose& T_world_base, const hal::PlanarPose& goal,
                      bool takes_heading, bool may_retrace, TimeNs now) {
  next_plan_ns_ = after(now, config_.plan_period_s);
  next_refresh_ns_ = after(now, config_.refresh_period_s);
  Way way = Way::open;
  const CellGrid<std::uint8_t>& cost = config_.known_cost != nullptr ? *config_.known_cost : floor.way_cost();
  Route route = planner_.plan(cost, T_world_base, goal, config_.goal_tolerance_m, config_.through_unknown);
  // A teammate goes away sooner or later: nearer to him is better than nowhere.
  is_behind_mate_ = route.status != PathStatus::found && &cost == &floor.way_cost() && &cost != &floor.cost();
  if (is_behind_mate_) route = planner_.plan(floor.cost(), T_world_base, goal, config_.goal_tolerance_m);
  if (route.status != PathStatus::found && may_retrace) {
    // It came that way: whoever stands there may be gone, and is seen from nearby.
    way = Way::own;
    route = planner_.plan(floor.cost_of_own_way(), T_world_base, goal, config_.goal_tolerance_m);
  }
  if (route.status == PathStatus::found) {
    follower_.set_path(route.points, takes_heading ? std::optional(goal.heading_rad) : std::nullopt);
    takes_any_heading_ = !takes_heading;
    return way;
  }
  follower_.clear();
  is_hemmed_in_ = nav::is_hemmed_in(floor.cost(), T_world_base);
  return Way::none;
}

void GoalPursuit::allow_time(TimeNs now) {
  goal_until_ns_ = after(now, follower_.track().length_m() / kSlowest_mps + kGoalGrace_s);
}

hal::Twist GoalPursuit::step(const Surroundings& floor, const hal::PlanarPose& T_world_base,
                             const hal::Twist& velocity) {
  const CellGrid<std::uint8_t>& cost = is_behind_mate_ ? floor.cost() : floor.way_cost();
  return follower_.step(T_world_base, velocity, floor.states(), cost, &floor);
}

std::optional<Waypoint> GoalPursuit::closed_at() const {
  if (!follower_.blocked_at_m()) return std::nullopt;
  return follower_.track().ahead(*follower_.blocked_at_m());
}

bool GoalPursuit::wants_path(TimeNs now) const {
  const bool is_worse = follower_.blocked_at_m() || follower_.is_shut() || follower_.track().offset_m() > kOffPath_m;
  return now >= (is_worse ? next_plan_ns_ : next_refresh_ns_);
}

bool GoalPursuit::is_shut_for_long(TimeNs now) {
  if (!follower_.is_shut()) {
    shut_since_ns_ = -1;
  } else if (shut_since_ns_ < 0) {
    shut_since_ns_ = now;
  } else {
    return now >= after(shut_since_ns_, config_.shut_s);
  }
  return false;
}

}  // namespace g3d::nav
