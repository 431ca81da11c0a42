// SPDX-License-Identifier: Apache-2.0
// Who says where the robot goes next. The navigator drives to the goals of one chooser, and tells it what became of
// them; the explorer is one, others serve as yardsticks on the same robot. One thread; the same calls give the same
// decisions.
//
// Use: call decide() about once a second while driving, and at once when a goal is reached or failed. A decision may
// take more work than there is time in one step: until there is one, go on with the old goal and call again in the next
// step. Drive to Decision::goal (position, then heading); a new decision replaces the old goal.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "hal/messages.hpp"
#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"
#include "nav/explained.hpp"
#include "nav/teammates.hpp"

namespace g3d::nav {

using hal::PlanarPose;
using hal::TimeNs;

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

class GoalChooser {
 public:
  GoalChooser() = default;
  virtual ~GoalChooser() = default;
  GoalChooser(const GoalChooser&) = delete;
  GoalChooser& operator=(const GoalChooser&) = delete;

  /// Reads the whole map and provides memory, so that no step has to.
  virtual void prepare(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost) = 0;
  /// `ground` and `cost` have one geometry; where the body may stand is cost < kInscribedCost. `changed_cells` are the
  /// indices whose ground or cost changed since the last call, in any order, repeats allowed; if the geometry changed,
  /// they are ignored and everything is read anew. The first call's pose is home. Nothing: it is not finished.
  [[nodiscard]] virtual std::optional<Decision> decide(const CellGrid<CellState>& ground,
                                                       const CellGrid<std::uint8_t>& cost,
                                                       std::span<const std::uint32_t> changed_cells,
                                                       const PlanarPose& T_world_base, TimeNs now) = 0;
  /// In steps without a decision: a share of the work that the next one would have to do first.
  virtual void work_ahead(const CellGrid<CellState>&, const CellGrid<std::uint8_t>&, std::span<const std::uint32_t>) {}
  /// The last decision was carried out: the pose stands there and the map holds what it saw.
  virtual void goal_reached() = 0;
  virtual void goal_failed(GoalFailure reason) = 0;

  /// Goes on exploring, also to what could not be reached: something that was closed has opened. What was looked at in
  /// vain stays given up.
  virtual void start_again() = 0;

  /// The map has moved by a little everywhere: whatever is planned is planned anew.
  virtual void map_moved() {}
  virtual void set_home(const PlanarPose& T_world_home) = 0;
  /// Seconds of driving that the battery still gives; infinite until set.
  virtual void set_energy_left(double seconds) = 0;
  /// Ends exploration: the next decisions lead home. `for_energy`: what is still open was left for the battery's sake.
  virtual void return_home(bool for_energy) = 0;

  /// What teammates claim, and what the leader wants; the latest counts. Alone (count 0) nothing is changed by it.
  virtual void set_team(const TeamSight&, TimeNs) {}
  /// Where it could go next, best first, as of the last decision. Returns how many.
  [[nodiscard]] virtual std::size_t offers(std::span<Offer, kMostOffers>) const { return 0; }

  /// Frontier cells as of the last decision (pictures, pages), indices ascending within no particular order.
  [[nodiscard]] virtual std::span<const std::uint32_t> frontier_cells() const = 0;
};

}  // namespace g3d::nav
