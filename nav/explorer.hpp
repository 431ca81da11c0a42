// SPDX-License-Identifier: Apache-2.0
// Where to look next. Goals are poses: places with a heading, because the camera sees only a slice of the room. They
// are chosen by what they would newly show per second of travel and turning, in an order over all frontier clusters,
// and reconsidered whenever the map has grown. One thread; memory is sized at start; the same calls give the same
// decisions.
//
// Use: call decide() about once a second while driving, and at once when a goal is reached or failed. It is cheap to
// call more often. Drive to Decision::goal (position, then heading); a new decision replaces the old goal.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "hal/messages.hpp"
#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"
#include "nav/explained.hpp"

namespace g3d::nav {

using hal::PlanarPose;
using hal::TimeNs;

struct ExplorerConfig {
  // The robot.
  double body_radius_m = 0.18;
  double speed_mps = 0.4;  ///< what it drives at in the open; weighs travel against turning
  double turn_radps = 1.0;
  // The camera, on the floor plane.
  double camera_forward_m = 0.0;  ///< in front of the base's origin
  double view_rad = 0.995;        ///< horizontal, all of it: 57 degrees
  double near_m = 0.8;            ///< nearer surfaces are not measured
  double far_m = 3.5;
  // What counts.
  int min_gain_cells = 12;    ///< a look that shows fewer cells of 5 cm is not worth a drive; scaled by area
  int max_tries = 3;          ///< fruitless looks or failed goals until a frontier is left for good
  double set_aside_s = 30.0;  ///< how long a failed or fruitless goal rests; doubles with every time
  bool look_around_first = true;
  // Where, world frame. A pose or unknown cell outside is none of ours. Empty (max <= min): everywhere.
  double area_min_x_m = 0.0;
  double area_min_y_m = 0.0;
  double area_max_x_m = 0.0;
  double area_max_y_m = 0.0;
  // Budgets.
  double home_reserve_factor = 1.3;  ///< times the travel time home,
  double home_reserve_s = 30.0;      ///< plus this, is kept of set_energy_left()
  int max_cells = 4'000'000;         ///< largest grid; memory grows with it
  int max_views_per_decision = 400;  ///< rays of so many places are cast anew in one decision; the rest waits
};

enum class DecisionKind : std::uint8_t {
  goal,         ///< drive to `goal`, then take its heading
  look_around,  ///< stay and turn by `turn_rad` (signed, may be a full turn)
  go_home,      ///< drive to `goal`: exploration is over (`left` says why); when reached, decide() says done
  done,         ///< at home, or no way home is known
};

struct Decision {
  DecisionKind kind = DecisionKind::done;
  PlanarPose goal;              ///< T_world_base
  double turn_rad = 0.0;        ///< look_around alone
  bool is_new = false;          ///< differs from the decision before: replan
  double expected_cells = 0.0;  ///< unknown cells that the goal is expected to show
  FrontiersLeft left;
};

enum class GoalFailure : std::uint8_t {
  no_path,  ///< the planner found none
  stuck,    ///< bumper, recovery gave up
  timeout,  ///< took far longer than planned, e.g. people in the way
};

class Explorer {
 public:
  explicit Explorer(const ExplorerConfig& config);
  ~Explorer();
  Explorer(const Explorer&) = delete;
  Explorer& operator=(const Explorer&) = delete;

  /// `ground` and `cost` have one geometry; where the body may stand is cost < kInscribedCost. `changed_cells` are the
  /// indices whose ground or cost changed since the last call, in any order, repeats allowed; if the geometry changed,
  /// they are ignored and everything is read anew. The first call's pose is home.
  [[nodiscard]] Decision decide(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost,
                                std::span<const std::uint32_t> changed_cells, const PlanarPose& T_world_base,
                                TimeNs now);
  /// The last decision was carried out: the pose stands there and the map holds what it saw.
  void goal_reached();
  void goal_failed(GoalFailure reason);

  void set_home(const PlanarPose& T_world_home);
  /// Seconds of driving that the battery still gives; infinite until set.
  void set_energy_left(double seconds);
  /// Ends exploration: the next decisions lead home.
  void return_home();

  /// Frontier cells as of the last decision (pictures, pages), indices ascending within no particular order.
  [[nodiscard]] std::span<const std::uint32_t> frontier_cells() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace g3d::nav
