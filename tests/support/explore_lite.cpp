// SPDX-License-Identifier: Apache-2.0
#include "tests/support/explore_lite.hpp"

#include "tests/support/flat_driver.hpp"

namespace g3d::tests {

FlatResult run_explore_lite(FlatSim& sim, double limit_s, const ExploreLiteConfig& config) {
  FlatResult result;
  ExploreLite explorer(config);
  FlatDriver driver(sim, true);
  bool has_goal = false;
  double next_plan_s = 0.0;
  while (sim.time_s() < limit_s) {
    if (sim.time_s() >= next_plan_s) {
      next_plan_s = sim.time_s() + config.period_s;
      const ExploreLite::Plan plan = explorer.make_plan(sim.ground(), sim.pose(), sim.time_s());
      if (plan == ExploreLite::Plan::stop) {
        result.ended = true;
        break;
      }
      if (plan == ExploreLite::Plan::drive) {
        driver.set_goal({explorer.goal().x_m, explorer.goal().y_m, 0.0});
        has_goal = true;
        ++result.goals;
      }
    }
    const DriveState state = has_goal ? driver.step() : DriveState::arrived;
    if (state == DriveState::driving) {
      note_progress(sim, result);
      continue;
    }
    if (state != DriveState::arrived) explorer.abort();
    // The original plans anew at once; time goes on even where it stands still.
    sim.step(0.0, 0.0);
    if (has_goal) next_plan_s = sim.time_s();
    has_goal = false;
  }
  note_end(sim, result);
  return result;
}

}  // namespace g3d::tests
