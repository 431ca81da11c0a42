// SPDX-License-Identifier: Apache-2.0
// The robot's own will, in one object without threads: map and base in, velocity out. Deterministic: the same calls
// give the same velocities, in lockstep as in real time.
//
//   on_map ──▶ ground map ──▶ inflation ──▶ ┐
//                                           ├─ explorer ──▶ route planner ──▶ follower ──▶ velocity
//   on_base ─▶ pose, contacts, safety ────▶ ┘      ▲             recovery ──────┘
//                                                  └── mission: pause, resume, stop, come home
//
// All calls from one thread. After construction nothing allocates but what the explorer reserved for itself. A step
// that decides and plans takes some milliseconds, the others some ten microseconds.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "hal/messages.hpp"
#include "hal/safety.hpp"
#include "hal/twist.hpp"
#include "mapper/voxel_map.hpp"
#include "nav/closed_ways.hpp"
#include "nav/explorer.hpp"
#include "nav/follower.hpp"
#include "nav/goal_history.hpp"
#include "nav/mission.hpp"
#include "nav/mission_report.hpp"
#include "nav/progress_watch.hpp"
#include "nav/recovery.hpp"
#include "nav/route_planner.hpp"
#include "nav/surroundings.hpp"

namespace g3d::nav {

/// What the base says, as of now.
struct BaseView {
  hal::PlanarPose T_world_base;
  hal::Twist velocity;      ///< measured
  std::uint8_t bumper = 0;  ///< kobuki flags: 1 right, 2 centre, 4 left
  std::uint8_t cliff = 0;
  hal::Verdict verdict{hal::SafetyState::free, hal::free_allowance(), hal::Condition::count_};
  double energy_left_s = std::numeric_limits<double>::infinity();  ///< of driving
};

struct NavigatorConfig {
  GroundMapConfig ground;
  LowViewConfig low_view;
  NearWatchConfig near_watch;
  double inflation_radius_m = 0.55;
  double inflation_decay_perm = 8.0;
  ExplorerConfig explorer;
  FollowerConfig follower;
  RecoveryConfig recovery;
  double decide_period_s = 1.0;
  double plan_period_s = 0.5;      ///< at most so often while the way is blocked
  double refresh_period_s = 3.0;   ///< a path is planned anew so often though nothing is wrong with it
  double goal_tolerance_m = 0.25;  ///< how far a substitute may lie from a goal that cannot be stood on
  double home_tolerance_m = 0.30;
  double shut_s = 0.4;  ///< nothing moves in front of a shut way for so long: trouble
  double no_progress_s = 3.0;
  double lost_s = 180.0;       ///< without having got anywhere: it needs help,
  double retry_s = 20.0;       ///< and tries by itself again after this,
  int max_retries = 5;         ///< so many times
  double closed_wait_s = 5.0;  ///< how long it watches a closed way before it takes it for closed
};

class Navigator {
 public:
  Navigator(const mapper::Grid& grid, const NavigatorConfig& config);

  /// After every frame: the blocks that it changed.
  void on_map(const mapper::VoxelMap& map, std::span<const std::uint32_t> changed_slots, TimeNs now);
  /// After every frame as well, with the pose it was taken from: for what is too near to be mapped.
  void on_frame(const hal::Frame& frame, const hal::CameraModel& camera, const hal::PlanarPose& T_world_base,
                TimeNs now);
  /// After every feedback packet. The first pose is home.
  void on_base(const BaseView& view, TimeNs now);
  /// 20 to 50 times a second: the velocity to command.
  [[nodiscard]] hal::Twist step(TimeNs now);
  /// A person's word: pause, resume, stop, come_home; and battery_low. Others are the navigator's own: ignored.
  void command(MissionEvent event);

  [[nodiscard]] const Mission& mission() const { return mission_; }
  [[nodiscard]] const Recovery& recovery() const { return recovery_; }
  [[nodiscard]] const Follower& follower() const { return follower_; }
  [[nodiscard]] const Decision& decision() const { return decision_; }  ///< with the goal
  [[nodiscard]] std::span<const Waypoint> path() const { return follower_.track().points(); }
  [[nodiscard]] std::span<const std::uint32_t> frontier_cells() const { return explorer_->frontier_cells(); }
  [[nodiscard]] const GroundMap& ground() const { return floor_.ground(); }
  [[nodiscard]] const CellGrid<std::uint8_t>& cost() const { return floor_.cost(); }
  [[nodiscard]] const hal::PlanarPose& home() const { return home_; }
  [[nodiscard]] const MissionReport& report() const { return report_; }
  [[nodiscard]] MissionReport& report() { return report_; }  ///< for note_coverage()
  /// While it wants to back off: whether the floor behind is known to be free. For the safety table.
  [[nodiscard]] bool is_rear_free() const { return free_behind_m_ >= kRearFree_m; }

 private:
  static constexpr double kRearFree_m = 0.03;

  void meet(std::uint8_t flags, TimeNs now);

  void decide(TimeNs now);
  void follow_decision(TimeNs now);
  bool plan(TimeNs now);
  void fail_goal(GoalFailure reason, TimeNs now);
  void finish(TimeNs now);
  [[nodiscard]] bool look_at_closed_way(TimeNs now);
  void watch_closed_way(TimeNs now);
  void explore_again();
  void begin_trouble(Trouble trouble, StopReason reason, double side, TimeNs now);
  [[nodiscard]] RecoveryView recovery_view(TimeNs now);
  [[nodiscard]] hal::Twist recover(TimeNs now);
  [[nodiscard]] hal::Twist drive(TimeNs now);
  [[nodiscard]] hal::Twist look_around(TimeNs now);
  [[nodiscard]] hal::Twist follow(TimeNs now);
  void watch_progress(const hal::Twist& twist, TimeNs now);
  void push_against(const hal::Twist& twist, TimeNs now);
  [[nodiscard]] bool stands_by(TimeNs now);
  void retry(TimeNs now);
  [[nodiscard]] bool is_at_home() const;

  NavigatorConfig config_;
  Surroundings floor_;
  std::unique_ptr<Explorer> explorer_;  ///< made anew when a closed way has opened
  RoutePlanner planner_;
  Follower follower_;
  ArcCheck behind_;
  Recovery recovery_;
  ProgressWatch progress_;
  hal::Twist last_twist_;
  TimeNs last_step_ns_ = 0;
  Mission mission_;
  MissionReport report_;

  BaseView base_;
  bool has_base_ = false;
  hal::PlanarPose home_;
  double free_behind_m_ = 0.0;

  Decision decision_;
  Decision followed_;  ///< what the follower, or the look around, is about
  bool is_on_way_home_ = false;
  TimeNs next_decision_ns_ = 0;
  TimeNs next_plan_ns_ = 0;
  TimeNs next_refresh_ns_ = 0;
  TimeNs goal_until_ns_ = 0;
  bool is_hemmed_in_ = false;  ///< as of the last plan
  int goals_in_vain_ = 0;      ///< failed for want of a path, one after the other
  GoalHistory left_goals_;
  ClosedWays closed_ways_;
  bool is_sent_home_ = false;
  bool was_reopened_ = false;
  bool is_checking_ = false;  ///< on the way to a closed way, or watching it
  Waypoint checked_;
  TimeNs watch_until_ns_ = -1;
  bool is_spinning_ = false;
  double spin_left_rad_ = 0.0;
  double spin_heading_rad_ = 0.0;

  TimeNs shut_since_ns_ = -1;  ///< -1: is not
  TimeNs retry_ns_ = -1;
  int retries_ = 0;
  bool is_standing_by_ = false;
};

}  // namespace g3d::nav
