// SPDX-License-Identifier: Apache-2.0
// The navigator where it has to stand for others: held by a person or by the safety table, and among teammates, for
// whom it waits or makes room.
#include "nav/navigator.hpp"

#include <algorithm>
#include <cmath>

#include "nav/seconds.hpp"
#include "nav/team_way.hpp"

namespace g3d::nav {
namespace {

constexpr double kRoomPeriod_s = 0.5;     // between searches for a place out of the way
constexpr double kRoomPatience_s = 15.0;  // to get there
constexpr double kRoomLeast_m = 0.10;     // nearer it would stand where it stands
constexpr double kOneWait_s = 1.0;        // after a longer pause it is another one
constexpr double kHolding_mps = 0.02;
constexpr double kTellsMoving_mps = 0.03;
constexpr double kSlowestTold_mps = 0.25;
constexpr double kNearMate_m = 0.55;  // a teammate's body this near to one's own middle may be what shuts the way
constexpr double kPathBearing_m = 0.35;
constexpr double kTurnsFirst_rad = 0.4;  // path so far to the side: it turns before it drives
constexpr double kTurnShare = 0.7;       // of the fastest turn, on average

hal::Twist slowed(const hal::Twist& twist, double forward_mps) {
  if (twist.forward_mps <= forward_mps) return twist;
  return {forward_mps, twist.turn_radps * forward_mps / twist.forward_mps};
}

}  // namespace

void Navigator::retry(TimeNs now) {
  if (!standby_.should_retry(mission_.state(), now)) return;
  progress_.note_got_on(base_.T_world_base, now);
  floor_.forget_touches();
  mission_.apply(MissionEvent::resume);
  next_decision_ns_ = now;
}

// Whether it has to stand: the mission is held or over, or the safety table says so.
bool Navigator::stands_by(TimeNs now) {
  const bool is_forbidden = base_.verdict.state == hal::SafetyState::stand;
  const bool stands = !mission_.is_driving() || is_forbidden;
  const Standby::Step standing = standby_.step(stands, now);
  if (standing.began && !mission_.is_over()) {
    report_.note_stop(is_forbidden ? StopReason::safety : StopReason::held);
    if (is_forbidden && base_.verdict.reason == hal::Condition::over_current) push_against(last_twist_, now);
  }
  if (standing.ended) pursuit_.refresh(now);
  pursuit_.leave_out(standing.stood_ns);
  progress_.leave_out(standing.stood_ns);
  return stands;
}

void Navigator::on_team(const TeamSight& sight, TimeNs now) {
  if (is_map_moving_) return;
  floor_.on_team(sight, now);
  chooser_->set_team(sight, now);
}

TeamWord Navigator::team_word(TimeNs) const {
  TeamWord word;
  if (!has_base_) return word;
  word.T_world_base = base_.T_world_base;
  word.is_moving = std::fabs(base_.velocity.forward_mps) > kTellsMoving_mps;
  const bool drives = mission_.is_driving() && base_.verdict.state != hal::SafetyState::stand && !is_map_moving_ &&
                      !recovery_.is_active() && !spin_.is_active() && !pursuit_.is_idle() && !is_yielding_;
  const double speed_mps =
      std::clamp(base_.velocity.forward_mps, kSlowestTold_mps, config_.follower.limits.max_speed_mps);
  const WayTold way = drives ? tell_way(follower().track(), base_.T_world_base, speed_mps, first_turn_s())
                             : tell_place(base_.T_world_base);
  word.way = way.points;
  word.way_count = way.count;
  const bool pursues = !pursuit_.is_idle() || recovery_.is_active() || is_deciding_;
  word.has_goal = mission_.state() == MissionState::exploring && followed_.kind == DecisionKind::goal && pursues &&
                  !closed_way_.is_active();
  word.goal = followed_.goal;
  if (mission_.state() == MissionState::exploring) word.offer_count = chooser_->offers(word.offers);
  return word;
}

double Navigator::first_turn_s() const {
  const PathTrack& track = follower().track();
  if (track.empty() || track.remaining_m() < kPathBearing_m) return 0.0;
  const Waypoint at = track.ahead(kPathBearing_m);
  const double bearing_rad = wrap_angle(std::atan2(at.y_m - base_.T_world_base.y_m, at.x_m - base_.T_world_base.x_m) -
                                        base_.T_world_base.heading_rad);
  if (std::fabs(bearing_rad) < kTurnsFirst_rad) return 0.0;
  return std::fabs(bearing_rad) / (kTurnShare * config_.follower.limits.max_turn_radps);
}

// What it may drive of what it wants to, among teammates.
hal::Twist Navigator::give_way(const hal::Twist& wanted, TimeNs now) {
  const TeamBodies& bodies = floor_.bodies();
  if (bodies.empty()) return wanted;
  const MotionLimits& limits = config_.follower.limits;
  const Passage passage =
      right_of_way_.judge(bodies.sight(), now, base_.T_world_base, follower().track(), first_turn_s());
  hal::Twist twist = wanted;
  if (passage.kind == Passage::Kind::make_room) {
    if (find_room(now)) return {};
    if (pursuit_.is_idle()) return {};
    twist = slowed(wanted, 0.0);
  } else if (passage.kind == Passage::Kind::hold) {
    twist = slowed(wanted, speed_to_stop_within(passage.within_m, limits.deceleration_mps2, limits.reaction_s));
  }
  const hal::PlanarPose& here = base_.T_world_base;
  const bool stands = twist.forward_mps < kHolding_mps && std::fabs(twist.turn_radps) < kHolding_mps;
  const bool is_held = passage.kind != Passage::Kind::free && twist.forward_mps < kHolding_mps;
  const bool is_shut = follower().is_shut() && bodies.is_near(here.x_m, here.y_m, kNearMate_m, now);
  is_yielding_ = is_held && passage.is_yielding;
  wait_for_others(stands && (is_held || is_shut), is_yielding_, now);
  return pursuit_.is_idle() ? hal::Twist{} : twist;
}

// Time that others take is not held against any goal; but whoever stays may have come to stay.
void Navigator::wait_for_others(bool waits, bool is_yielding, TimeNs now) {
  const bool was_waiting = waits_since_ns_ >= 0 && now < after(last_wait_ns_, kOneWait_s);
  if (!waits) {
    waits_since_ns_ = -1;
    return;
  }
  if (!was_waiting) {
    waits_since_ns_ = last_wait_ns_ = now;
    report_.note_stop(StopReason::teammate);
  }
  const TimeNs waited_ns = now - last_wait_ns_;
  last_wait_ns_ = now;
  pursuit_.leave_out(waited_ns);
  progress_.leave_out(waited_ns);
  pursuit_.forget_shut();
  if (now < after(waits_since_ns_, is_yielding ? config_.mate_passes_s : config_.mate_stands_s)) return;
  waits_since_ns_ = -1;
  is_yielding_ = false;
  if (decision_.kind == DecisionKind::goal) {
    fail_goal(GoalFailure::timeout, now);
  } else {
    begin_trouble(Trouble::shut, StopReason::shut, 0.0, now);
  }
}

bool Navigator::find_room(TimeNs now) {
  if (now < next_room_ns_) return false;
  next_room_ns_ = after(now, kRoomPeriod_s);
  const hal::PlanarPose& here = base_.T_world_base;
  const auto room = refuge_.find(floor_.way_cost(), floor_.bodies().sight(), now, here, right_of_way_.config());
  if (!room || std::hypot(room->x_m - here.x_m, room->y_m - here.y_m) < kRoomLeast_m) return false;
  if (pursuit_.plan(floor_, here, *room, false, false, now) == Way::none) {
    (void)plan(now);
    return false;
  }
  is_making_room_ = true;
  is_yielding_ = false;
  waits_since_ns_ = -1;
  room_until_ns_ = after(now, kRoomPatience_s);
  return true;
}

// On the way to a place out of the way; from there it goes on to where it was going.
hal::Twist Navigator::make_room(const hal::Twist& wanted, TimeNs now) {
  const bool is_over = pursuit_.has_arrived() || now >= room_until_ns_ || pursuit_.is_shut_for_long(now);
  if (!is_over) return wanted;
  pursuit_.forget_shut();
  (void)plan(now);
  return {};
}

}  // namespace g3d::nav
