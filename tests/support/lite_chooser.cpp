// SPDX-License-Identifier: Apache-2.0
#include "tests/support/lite_chooser.hpp"

#include <memory>

namespace g3d::tests {

std::optional<nav::Decision> LiteChooser::decide(const nav::CellGrid<nav::CellState>& ground,
                                                 const nav::CellGrid<std::uint8_t>&, std::span<const std::uint32_t>,
                                                 const hal::PlanarPose& T_world_base, hal::TimeNs now) {
  nav::Decision decision;  // done: it stops, and our robot goes home by itself
  if (is_over_) return decision;
  const ExploreLite::Plan plan = lite_.make_plan(ground, T_world_base, static_cast<double>(now) * 1e-9);
  if (plan == ExploreLite::Plan::stop) {
    is_over_ = true;
    return decision;
  }
  decision.kind = nav::DecisionKind::goal;
  decision.is_new = plan == ExploreLite::Plan::drive;
  decision.goal = {lite_.goal().x_m, lite_.goal().y_m, 0.0};
  return decision;
}

void drive_like_explore_lite(nav::NavigatorConfig& config) {
  const ExploreLiteConfig lite;
  config.make_chooser = [lite](const nav::ExplorerConfig&) { return std::make_unique<LiteChooser>(lite); };
  config.decide_period_s = lite.period_s;
  config.is_steadfast = false;
  config.pursuit.through_unknown = true;
  config.pursuit.goal_tolerance_m = 0.0;
}

}  // namespace g3d::tests
