// SPDX-License-Identifier: Apache-2.0
// The drive to one goal: a way there, planned anew when it gets worse, and the follower on it; when the goal takes too
// long, and when the way is shut for longer than somebody takes to walk by. What then is to be done is not decided
// here. One thread. After construction nothing allocates.
#pragma once

#include <cstdint>
#include <optional>

#include "hal/messages.hpp"
#include "hal/twist.hpp"
#include "nav/follower.hpp"
#include "nav/route_planner.hpp"
#include "nav/surroundings.hpp"

namespace g3d::nav {

struct PursuitConfig {
  double plan_period_s = 0.5;      ///< at most so often while the way is blocked
  double refresh_period_s = 3.0;   ///< a path is planned anew so often though nothing is wrong with it
  double goal_tolerance_m = 0.25;  ///< how far a substitute may lie from a goal that cannot be stood on
  double shut_s = 0.4;             ///< nothing moves in front of a shut way for so long: trouble
  bool through_unknown = false;    ///< paths may lead where nobody has looked
  /// Costs of the whole building, for a yardstick that knows it; none: what the robot has seen counts.
  const CellGrid<std::uint8_t>* known_cost = nullptr;
};

enum class Way : std::uint8_t {
  none,
  open,  ///< over floor where the body fits
  own,   ///< only back the way it came, where something seems to stand now
};

class GoalPursuit {
 public:
  GoalPursuit(const CellGrid<CellState>& states, const FollowerConfig& follower, const PursuitConfig& config);

  /// Takes the best way from here to `goal`; none stops the pursuit. With `may_retrace` the own way counts as one,
  /// without `takes_heading` any heading at the goal will do.
  Way plan(Surroundings& floor, const hal::PlanarPose& T_world_base, const hal::PlanarPose& goal, bool takes_heading,
           bool may_retrace, TimeNs now);
  /// The goal may take as long as its way is worth, from now on.
  void allow_time(TimeNs now);
  /// It had to stand for so long: that does not count.
  void leave_out(TimeNs duration_ns) { goal_until_ns_ += duration_ns; }
  /// Much may have changed: a new path at the next step.
  void refresh(TimeNs now) { next_refresh_ns_ = now; }
  void clear() { follower_.clear(); }

  /// The velocity to command now.
  [[nodiscard]] hal::Twist step(const Surroundings& floor, const hal::PlanarPose& T_world_base,
                                const hal::Twist& velocity);
  // Of the last step:
  [[nodiscard]] bool has_arrived() const { return follower_.state() == FollowerState::arrived; }
  /// The first place on the path where the body cannot be any more.
  [[nodiscard]] std::optional<Waypoint> closed_at() const;
  [[nodiscard]] bool wants_path(TimeNs now) const;
  [[nodiscard]] bool is_late(TimeNs now) const { return now >= goal_until_ns_; }
  /// To be asked once per step: whether the way has been shut for too long.
  [[nodiscard]] bool is_shut_for_long(TimeNs now);
  void forget_shut() { shut_since_ns_ = -1; }

  [[nodiscard]] bool is_idle() const { return follower_.state() == FollowerState::idle; }
  /// The last path that was found asked for no heading.
  [[nodiscard]] bool takes_any_heading() const { return takes_any_heading_; }
  /// As of the last plan() that found none: there is no way to get anywhere from here.
  [[nodiscard]] bool is_hemmed_in() const { return is_hemmed_in_; }
  [[nodiscard]] TimeNs goal_until_ns() const { return goal_until_ns_; }
  [[nodiscard]] const Follower& follower() const { return follower_; }

 private:
  PursuitConfig config_;
  RoutePlanner planner_;
  Follower follower_;
  bool takes_any_heading_ = false;
  bool is_hemmed_in_ = false;
  bool is_behind_mate_ = false;  ///< the path leads through a teammate who stands there
  TimeNs next_plan_ns_ = 0;
  TimeNs next_refresh_ns_ = 0;
  TimeNs goal_until_ns_ = 0;
  TimeNs shut_since_ns_ = -1;  ///< -1: is not
};

}  // namespace g3d::nav
