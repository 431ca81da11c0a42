// SPDX-License-Identifier: Apache-2.0
// Runs the explorer on a floor plan, as the robot's navigator would: decide, drive, report back.
#pragma once

#include <optional>
#include <span>

#include "nav/explorer.hpp"
#include "tests/support/flat_run.hpp"

namespace g3d::tests {

/// Until it is home again, `limit_s` is over or that share is covered. `trace` prints every new goal.
[[nodiscard]] FlatResult run_explorer(FlatSim& sim, double limit_s, const nav::ExplorerConfig& config = {},
                                      bool trace = false, double enough = 2.0);

/// However many calls it takes, with everything frozen meanwhile.
inline nav::Decision decide_at_once(nav::GoalChooser& chooser, const nav::CellGrid<nav::CellState>& ground,
                                    const nav::CellGrid<std::uint8_t>& cost, std::span<const std::uint32_t> changed,
                                    const hal::PlanarPose& T_world_base, hal::TimeNs now) {
  std::optional<nav::Decision> decision = chooser.decide(ground, cost, changed, T_world_base, now);
  while (!decision) decision = chooser.decide(ground, cost, {}, T_world_base, now);
  return *decision;
}

}  // namespace g3d::tests
