// SPDX-License-Identifier: Apache-2.0
#include "tests/support/flat_explore.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/support/flat_driver.hpp"

namespace g3d::tests {

FlatResult run_explorer(FlatSim& sim, double limit_s, const nav::ExplorerConfig& config, bool trace, double enough) {
  FlatResult result;
  nav::Explorer explorer(config);
  FlatDriver driver(sim, false);
  const hal::PlanarPose start = sim.pose();
  double next_decision_s = 0.0;
  double turn_left_rad = 0.0;
  nav::Decision decision;
  bool has_decision = false;
  while (sim.time_s() < limit_s && sim.coverage() < enough) {
    if (sim.time_s() >= next_decision_s) {
      const auto changed = sim.take_changed();
      decision = decide_at_once(explorer, sim.ground(), sim.cost(), changed, sim.pose(),
                                static_cast<hal::TimeNs>(std::llround(sim.time_s() * 1e9)));
      next_decision_s = sim.time_s() + 0.2;
      if (decision.kind == nav::DecisionKind::done) {
        result.ended = true;
        break;
      }
      if (decision.is_new || !has_decision) {
        turn_left_rad = decision.turn_rad;
        ++result.goals;
        if (decision.kind != nav::DecisionKind::look_around) driver.set_goal(decision.goal);
        if (trace) {
          fmt::print(
              "{:7.1f} s {:5.2f} %  at {:5.2f} {:5.2f} {:5.2f}  {} {:5.2f} {:5.2f} {:5.2f} for {:.0f} cells, open {}\n",
              sim.time_s(), 100 * sim.coverage(), sim.pose().x_m, sim.pose().y_m, sim.pose().heading_rad,
              static_cast<int>(decision.kind), decision.goal.x_m, decision.goal.y_m, decision.goal.heading_rad,
              decision.expected_cells, decision.left.open);
        }
      }
      has_decision = true;
    }
    if (decision.kind == nav::DecisionKind::look_around) {
      const double turn = std::clamp(turn_left_rad, -0.1, 0.1);
      sim.step(0.0, turn / FlatSim::kStep_s);
      turn_left_rad -= turn;
      if (std::abs(turn_left_rad) < 1e-6) {
        explorer.goal_reached();
        next_decision_s = sim.time_s();
      }
      note_progress(sim, result);
      continue;
    }
    const DriveState state = driver.step();
    if (state == DriveState::driving) {
      note_progress(sim, result);
      continue;
    }
    if (state == DriveState::arrived) {
      explorer.goal_reached();
    } else {
      if (trace) fmt::print("failed: {}\n", state == DriveState::no_path ? "no path" : "stuck");
      explorer.goal_failed(state == DriveState::no_path ? nav::GoalFailure::no_path : nav::GoalFailure::stuck);
      sim.step(0.0, 0.0);
    }
    next_decision_s = sim.time_s();
  }
  for (std::size_t i = 0; i < nav::kLeftReasons; ++i) {
    if (decision.left.clusters[i] == 0) continue;
    result.left += fmt::format(" {}={}", nav::name_of(static_cast<nav::LeftReason>(i)), decision.left.clusters[i]);
  }
  result.home = std::hypot(sim.pose().x_m - start.x_m, sim.pose().y_m - start.y_m) < 0.3;
  note_end(sim, result);
  return result;
}

}  // namespace g3d::tests
