// SPDX-License-Identifier: Apache-2.0
// Where to look next. Goals are poses: places with a heading, because the camera sees only a slice of the room. They
// are chosen by what they would newly show per second of travel and turning, in an order over all frontier clusters,
// and reconsidered whenever the map has grown. One thread; memory is sized at start; the same calls give the same
// decisions.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "nav/goal_chooser.hpp"

namespace g3d::nav {

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
  double home_reserve_factor = 1.3;          ///< times the travel time home,
  double home_reserve_s = 30.0;              ///< plus this, is kept of set_energy_left()
  int max_cells = 4'000'000;                 ///< largest grid; memory grows with it
  int max_views_per_decision = 400;          ///< rays of so many places are cast anew in one decision; the rest waits
  std::int64_t max_units_per_call = 35'000;  ///< of work (work_budget.hpp) in one decide(),
  std::int64_t max_units_ahead_per_call = 5'000;  ///< and in one work_ahead()
};

class Explorer final : public GoalChooser {
 public:
  explicit Explorer(const ExplorerConfig& config);
  ~Explorer() override;

  void prepare(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost) override;
  [[nodiscard]] std::optional<Decision> decide(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost,
                                               std::span<const std::uint32_t> changed_cells,
                                               const PlanarPose& T_world_base, TimeNs now) override;
  void work_ahead(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost,
                  std::span<const std::uint32_t> changed_cells) override;
  void goal_reached() override;
  void goal_failed(GoalFailure reason) override;
  void start_again() override;
  void map_moved() override;
  void set_home(const PlanarPose& T_world_home) override;
  void set_energy_left(double seconds) override;
  void return_home(bool for_energy) override;
  void set_team(const TeamSight& sight, TimeNs now) override;
  [[nodiscard]] std::size_t offers(std::span<Offer, kMostOffers> out) const override;
  [[nodiscard]] std::span<const std::uint32_t> frontier_cells() const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

[[nodiscard]] std::unique_ptr<GoalChooser> make_explorer(const ExplorerConfig& config);

}  // namespace g3d::nav
