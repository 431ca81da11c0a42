// SPDX-License-Identifier: Apache-2.0
// A yardstick: the tour planned with full knowledge of the building (tour_plan.hpp) as the one who chooses the goals of
// our robot. Views of which everything is known already are left out. What a tour was to show and the real camera did
// not measure is toured again until 99.2 % are known, three times at most.
#pragma once

#include <memory>
#include <vector>

#include "hal/sim/observable.hpp"
#include "hal/sim/world.hpp"
#include "nav/navigator.hpp"
#include "tests/support/tour_plan.hpp"

namespace g3d::tests {

/// What is known of a building by whoever planned the tour.
struct BuildingPlan {
  hal::Observable observable;
  std::vector<TourPlace> places;
  nav::CellGrid<std::uint8_t> cost;  ///< true costs, inflated as the robot's own
};
[[nodiscard]] BuildingPlan survey(const hal::World& world, const hal::Observable& observable,
                                  const nav::NavigatorConfig& config);

class TourChooser final : public nav::GoalChooser {
 public:
  /// `plan` outlives it.
  TourChooser(const BuildingPlan& plan, double body_radius_m) : plan_(plan), body_radius_m_(body_radius_m) {}

  void prepare(const nav::CellGrid<nav::CellState>&, const nav::CellGrid<std::uint8_t>&) override {}
  [[nodiscard]] std::optional<nav::Decision> decide(const nav::CellGrid<nav::CellState>& ground,
                                                    const nav::CellGrid<std::uint8_t>& cost,
                                                    std::span<const std::uint32_t> changed_cells,
                                                    const hal::PlanarPose& T_world_base, hal::TimeNs now) override;
  void goal_reached() override { is_over_ = true; }
  void goal_failed(nav::GoalFailure) override { is_over_ = true; }
  void start_again() override {}
  void set_home(const hal::PlanarPose&) override {}
  void set_energy_left(double) override {}
  void return_home(bool) override { rounds_ = kRounds; }
  [[nodiscard]] std::span<const std::uint32_t> frontier_cells() const override { return {}; }

 private:
  static constexpr int kRounds = 4;
  static constexpr double kShare = 0.992;

  void plan_round(const nav::CellGrid<nav::CellState>& ground, const hal::PlanarPose& T_world_base);
  [[nodiscard]] bool is_known(const nav::CellGrid<nav::CellState>& ground, std::uint32_t cell) const;

  const BuildingPlan& plan_;
  double body_radius_m_;
  std::vector<TourView> views_;  ///< in order
  std::size_t next_ = 0;
  bool is_over_ = false;  ///< the view at `next_`
  bool is_new_ = true;
  int rounds_ = 0;
};

/// Full knowledge: paths are planned on the true costs, and a view is left as soon as it has nothing more to show.
void drive_tour(nav::NavigatorConfig& config, const BuildingPlan& plan);

}  // namespace g3d::tests
