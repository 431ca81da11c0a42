// SPDX-License-Identifier: Apache-2.0
// A yardstick: explore_lite (lite_plan.hpp) as the one who chooses the goals of our robot. What drives to them is ours.
#pragma once

#include "nav/navigator.hpp"
#include "tests/support/lite_plan.hpp"

namespace g3d::tests {

class LiteChooser final : public nav::GoalChooser {
 public:
  explicit LiteChooser(const ExploreLiteConfig& config = {}) : lite_(config) {}

  void prepare(const nav::CellGrid<nav::CellState>&, const nav::CellGrid<std::uint8_t>&) override {}
  [[nodiscard]] std::optional<nav::Decision> decide(const nav::CellGrid<nav::CellState>& ground,
                                                    const nav::CellGrid<std::uint8_t>& cost,
                                                    std::span<const std::uint32_t> changed_cells,
                                                    const hal::PlanarPose& T_world_base, hal::TimeNs now) override;
  void goal_reached() override {}
  void goal_failed(nav::GoalFailure) override { lite_.abort(); }
  void start_again() override {}
  void set_home(const hal::PlanarPose&) override {}
  void set_energy_left(double) override {}
  void return_home(bool) override { is_over_ = true; }
  [[nodiscard]] std::span<const std::uint32_t> frontier_cells() const override { return {}; }

 private:
  ExploreLite lite_;
  bool is_over_ = false;
};

/// What is explore_lite's and move_base's own rather than ours: how often it plans, that it leaves goals as it likes,
/// and that paths may lead through what is unknown, to the goal and to nowhere else (navfn's defaults).
void drive_like_explore_lite(nav::NavigatorConfig& config);

}  // namespace g3d::tests
