// SPDX-License-Identifier: Apache-2.0
// The robot's own will, in one object without threads: map and base in, velocity out. Deterministic: the same calls
// give the same velocities, in lockstep as in real time.
//
//   on_map ──▶ ground map ──▶ inflation ──▶ ┐
//                                           ├─ goal chooser ──▶ goal pursuit ──▶ velocity
//   on_base ─▶ pose, contacts, safety ────▶ ┘      ▲               recovery ──────┘
//                                                  └── mission: pause, resume, stop, come home
//
// All calls from one thread. After construction nothing allocates. A step that decides or plans takes some
// milliseconds, the others some ten microseconds; decisions take several steps.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "hal/messages.hpp"
#include "hal/safety.hpp"
#include "hal/twist.hpp"
#include "mapper/voxel_map.hpp"
#include "nav/closed_way_check.hpp"
#include "nav/explorer.hpp"
#include "nav/follower.hpp"
#include "nav/goal_chooser.hpp"
#include "nav/goal_history.hpp"
#include "nav/goal_pursuit.hpp"
#include "nav/mission.hpp"
#include "nav/mission_report.hpp"
#include "nav/progress_watch.hpp"
#include "nav/recovery.hpp"
#include "nav/refuge.hpp"
#include "nav/right_of_way.hpp"
#include "nav/spin.hpp"
#include "nav/standby.hpp"
#include "nav/surroundings.hpp"
#include "nav/teammates.hpp"

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
  FrameViewConfig frame_view;
  double inflation_radius_m = 0.55;
  double inflation_decay_perm = 8.0;
  ExplorerConfig explorer;
  std::function<std::unique_ptr<GoalChooser>(const ExplorerConfig&)> make_chooser = make_explorer;
  PursuitConfig pursuit;
  FollowerConfig follower;
  RecoveryConfig recovery;
  RightOfWayConfig right_of_way;
  double decide_period_s = 1.0;
  bool is_steadfast = true;  ///< a goal that is taken up again soon after it was left is driven to the end
  double home_tolerance_m = 0.30;
  double no_progress_s = 3.0;
  double lost_s = 180.0;        ///< without having got anywhere: it needs help,
  double retry_s = 20.0;        ///< and tries by itself again after this,
  int max_retries = 5;          ///< so many times
  double mate_stands_s = 8.0;   ///< how long it waits behind a teammate who stands in its way,
  double mate_passes_s = 20.0;  ///< and for those who go first; then another goal may do as well
  double closed_wait_s = 5.0;   ///< how long it watches a closed way before it takes it for closed
};

class Navigator {
 public:
  Navigator(const mapper::Grid& grid, const NavigatorConfig& config);

  /// After every frame: the blocks that it changed, and their columns if a card has read them by column_tables().
  void on_map(const mapper::VoxelMap& map, std::span<const std::uint32_t> changed_slots,
              const mapper::ChangedColumns& columns, TimeNs) {
    floor_.on_map(map, changed_slots, base_.T_world_base, columns);
  }
  [[nodiscard]] const mapper::ColumnTables& column_tables() const { return ground().column_tables(); }
  /// After every frame as well, with the pose it was taken from: for what is too near to be mapped.
  void on_frame(const hal::Frame& frame, const hal::CameraModel& camera, const hal::PlanarPose& T_world_base,
                TimeNs now) {
    floor_.on_frame(frame, camera, T_world_base, now);
  }
  /// The map is about to move, or a part of it has: it stands until on_map_moved().
  void on_map_moving(const mapper::VoxelMap& map, std::span<const std::uint32_t> changed_slots);
  void on_map_moved(const mapper::submaps::ChainMove& move, TimeNs now);
  /// After every feedback packet. The first pose is home.
  void on_base(const BaseView& view, TimeNs now);
  /// What the safety table says while no packet comes: a robot that may not move has not got stuck.
  void on_verdict(const hal::Verdict& verdict) { base_.verdict = verdict; }
  /// 20 to 50 times a second: the velocity to command.
  [[nodiscard]] hal::Twist step(TimeNs now);
  /// A person's word: pause, resume, stop, come_home; and battery_low. Others are the navigator's own: ignored.
  void command(MissionEvent event);

  /// What teammates say, whenever there is news, and a few times a second: see teammates.hpp. A robot that never hears
  /// of any does nothing differently.
  void on_team(const TeamSight& sight, TimeNs now);
  /// What there is to tell them. Some ten microseconds.
  [[nodiscard]] TeamWord team_word(TimeNs now) const;

  [[nodiscard]] const Mission& mission() const { return mission_; }
  [[nodiscard]] const Recovery& recovery() const { return recovery_; }
  [[nodiscard]] const Follower& follower() const { return pursuit_.follower(); }
  [[nodiscard]] const Decision& decision() const { return decision_; }  ///< with the goal
  [[nodiscard]] std::span<const Waypoint> path() const { return follower().track().points(); }
  [[nodiscard]] std::span<const std::uint32_t> frontier_cells() const { return chooser_->frontier_cells(); }
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
  void note_failed_here();
  void fail_goal(GoalFailure reason, TimeNs now);
  void finish(TimeNs now);
  [[nodiscard]] bool look_at_closed_way(TimeNs now);
  void judge_closed_way(ClosedWayCheck::Finding finding, TimeNs now);
  void explore_again();
  void begin_trouble(Trouble trouble, StopReason reason, double side, TimeNs now);
  [[nodiscard]] RecoveryView recovery_view(TimeNs now);
  [[nodiscard]] hal::Twist recover(TimeNs now);
  [[nodiscard]] hal::Twist drive(TimeNs now);
  [[nodiscard]] hal::Twist look_around(TimeNs now);
  [[nodiscard]] hal::Twist follow(TimeNs now);
  void arrive(TimeNs now);
  void watch_progress(const hal::Twist& twist, TimeNs now);
  void push_against(const hal::Twist& twist, TimeNs now);
  [[nodiscard]] bool stands_by(TimeNs now);
  void retry(TimeNs now);
  [[nodiscard]] bool is_at_home() const;

  // Others (navigator_waiting.cpp)
  [[nodiscard]] double first_turn_s() const;
  [[nodiscard]] hal::Twist give_way(const hal::Twist& wanted, TimeNs now);
  void wait_for_others(bool waits, bool is_yielding, TimeNs now);
  [[nodiscard]] bool find_room(TimeNs now);
  [[nodiscard]] hal::Twist make_room(const hal::Twist& wanted, TimeNs now);
  [[nodiscard]] bool is_making_room() const { return is_making_room_ && !pursuit_.is_idle(); }

  NavigatorConfig config_;
  Surroundings floor_;
  std::unique_ptr<GoalChooser> chooser_;
  GoalPursuit pursuit_;
  ArcCheck behind_;
  Recovery recovery_;
  Spin spin_;
  ClosedWayCheck closed_way_;
  Standby standby_;
  ProgressWatch progress_;
  RightOfWay right_of_way_;
  Refuge refuge_;
  Mission mission_;
  MissionReport report_;

  BaseView base_;
  bool has_base_ = false;
  bool is_map_moving_ = false;
  hal::PlanarPose home_;
  TimeNs home_ns_ = 0;
  double free_behind_m_ = 0.0;
  hal::Twist last_twist_;

  Decision decision_;
  Decision followed_;  ///< what the pursuit, or the look around, is about
  TimeNs next_decision_ns_ = 0;
  bool is_deciding_ = false;
  TimeNs decision_begun_ns_ = 0;
  int goals_in_vain_ = 0;  ///< failed for want of a path, one after the other
  hal::PlanarPose failed_at_;
  int failed_here_ = 0;  ///< goals, without getting away
  GoalHistory left_goals_;
  bool is_sent_home_ = false;
  bool was_reopened_ = false;

  bool is_yielding_ = false;     ///< it stands for one who goes first
  bool is_making_room_ = false;  ///< what is pursued is no goal but a place out of the way
  TimeNs room_until_ns_ = 0;
  TimeNs next_room_ns_ = 0;
  TimeNs waits_since_ns_ = -1;  ///< -1: it does not wait for others
  TimeNs last_wait_ns_ = 0;
};

}  // namespace g3d::nav
