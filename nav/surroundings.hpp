// SPDX-License-Identifier: Apache-2.0
// All that navigation knows of the floor, and how well: the ground map from the voxels, its costs, what the body itself
// has trodden and touched, how low the camera has looked, who passes by, and what stands too near to be measured.
// One thread. After construction nothing allocates.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hal/messages.hpp"
#include "hal/twist.hpp"
#include "mapper/voxel_map.hpp"
#include "nav/arc_check.hpp"
#include "nav/body_trace.hpp"
#include "nav/depth_scan.hpp"
#include "nav/floor_steps.hpp"
#include "nav/ground_map.hpp"
#include "nav/inflation.hpp"
#include "nav/low_view.hpp"
#include "nav/moved_lately.hpp"
#include "nav/near_watch.hpp"
#include "nav/passers.hpp"
#include "nav/team_bodies.hpp"
#include "nav/team_cost.hpp"
#include "nav/tight_places.hpp"
#include "nav/trodden_way.hpp"

namespace g3d::nav {

/// What every frame is looked at for, besides being mapped.
struct FrameViewConfig {
  DepthScanConfig depth_scan;
  PassersConfig passers;
  FloorStepsConfig floor_steps;
};

struct SurroundingsConfig {
  GroundMapConfig ground;
  LowViewConfig low_view;
  NearWatchConfig near_watch;
  FrameViewConfig frame_view;
  double body_radius_m = 0.18;
  double inflation_radius_m = 0.55;
  double inflation_decay_perm = 8.0;
};

/// The inscribed radius that planning uses: cells are squares, and a body whose centre is somewhere in its cell must
/// still pass what is somewhere in another.
[[nodiscard]] double planning_radius_m(double body_radius_m, double cell_m);

class Surroundings final : public FloorKnowledge {
 public:
  Surroundings(const mapper::Grid& grid, const SurroundingsConfig& config);

  /// `columns`: of the same blocks, if a card has read them.
  void on_map(const mapper::VoxelMap& map, std::span<const std::uint32_t> changed_slots,
              const hal::PlanarPose& T_world_base, const mapper::ChangedColumns& columns = {});
  void on_frame(const hal::Frame& frame, const hal::CameraModel& camera, const hal::PlanarPose& T_world_base,
                TimeNs now);
  /// The body is here, now.
  void on_pose(const hal::PlanarPose& T_world_base, TimeNs now);
  /// Something was touched by this part of the bumper (0 ahead, kBumperSide_rad left, -kBumperSide_rad right). Touches
  /// near one another are of one thing: what lies between them is closed as well.
  void on_touch(const hal::PlanarPose& T_world_base, double side_rad);
  /// What teammates say of themselves, the latest word of all. Nobody drives into their bodies, and no path leads
  /// through those that stand.
  void on_team(const TeamSight& sight, TimeNs now);
  /// What is suspect right now has not gone away: the way there is closed until reopen(), for planning as well.
  void close_suspects();
  /// Forgets what close_suspects() closed. False if there was nothing.
  bool reopen();
  /// Where the body has been it can be again, also for choosing goals: for a robot that is cut off from where it came
  /// from. False if that opens nothing.
  bool trust_own_way();
  void forget_touches();
  /// While the map moves, a part with every on_map(): nobody has come where something stands now.
  void begin_to_move() { is_moving_ = true; }
  /// It has moved: so does all that is known besides the voxels. Takes some ten milliseconds.
  void move(const mapper::submaps::ChainMove& move);

  [[nodiscard]] const GroundMap& ground() const { return ground_; }
  [[nodiscard]] const CellGrid<CellState>& states() const { return ground_.states(); }
  [[nodiscard]] const CellGrid<std::uint8_t>& cost() const { return tight_.cost(); }
  /// The same with teammates that stand about, for paths. It is cost() itself where there are none.
  [[nodiscard]] const CellGrid<std::uint8_t>& way_cost() const {
    return team_cost_.empty() ? cost() : team_cost_.cost();
  }
  [[nodiscard]] const TeamBodies& bodies() const { return bodies_; }
  /// The same, but where the body has been it may be again, at a high cost: for the way back. Copies the whole grid.
  [[nodiscard]] const CellGrid<std::uint8_t>& cost_of_own_way();
  /// Cells whose state or cost changed since forget_changes(), each once.
  [[nodiscard]] std::span<const std::uint32_t> changed_cells() const { return changed_; }
  void forget_changes();

  [[nodiscard]] bool is_seen(Cell c) const override;
  [[nodiscard]] bool is_unwatched(Cell c) const override { return passers_.may_have_come(c, now_ns_); }
  [[nodiscard]] bool is_suspect(Cell c) const override {
    return near_watch_.is_suspect(c, now_ns_) || passers_.is_there(c, now_ns_) ||
           (!bodies_.empty() && bodies_.may_be_at(states().centre_x_m(c), states().centre_y_m(c)));
  }
  /// While it trusts its own way: what reaches into it by a cell is noise, what is beside it begins in a cell's middle.
  [[nodiscard]] Extent extent(Cell c) const override;

 private:
  void mark_touches_with(const Waypoint& touch, std::size_t others);
  void mark_all_touches();
  void take_over_changes();
  void note_changed(std::span<const std::uint32_t> cells);
  void find_near_touches();
  void let_bodies_stand(TimeNs now);

  double body_radius_m_;
  GroundMap ground_;
  Inflation inflation_;
  TightPlaces tight_;
  BodyTrace trace_;
  TroddenWay way_;
  MoveField field_;
  LowView low_view_;
  NearWatch near_watch_;
  MovedLately moved_;
  DepthScan scan_;
  Passers passers_;
  FloorSteps steps_;
  TeamBodies bodies_;
  TeamCost team_cost_;
  TimeNs next_stand_ns_ = 0;
  bool has_frames_ = false;  ///< else the map alone has to say where the camera looked
  TimeNs now_ns_ = 0;
  std::vector<Waypoint> touches_;
  bool has_closed_ = false;
  bool trusts_own_way_ = false;
  bool is_moving_ = false;
  hal::PlanarPose here_;
  std::vector<std::uint8_t> scratch_;
  std::vector<Waypoint> near_touches_;  ///< near enough to matter for where the robot is
  std::vector<std::uint32_t> changed_;
  std::vector<std::uint8_t> is_noted_;
  CellGrid<std::uint8_t> own_way_;
  std::size_t taken_over_ = 0;  ///< how many of the ground map's changed cells
};

}  // namespace g3d::nav
