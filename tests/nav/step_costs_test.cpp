// SPDX-License-Identifier: Apache-2.0
#include "nav/step_costs.hpp"

#include <catch2/catch.hpp>

using namespace g3d::nav;

TEST_CASE("Steps cost more the closer they come to obstacles, and none leads into one") {
  const StepCosts steps = make_step_costs({});
  CHECK(steps.straight[0] == kStraightCost);
  CHECK(steps.diagonal[0] == kDiagonalCost);
  for (std::size_t cost = 1; cost < kInscribedCost; ++cost) {
    CHECK(steps.straight[cost] >= steps.straight[cost - 1]);
    CHECK(steps.diagonal[cost] >= kDiagonalCost);
  }
  CHECK(steps.straight[252] == 252);
  CHECK(steps.straight[kInscribedCost] == 0);
  CHECK(steps.straight[kLethalCost] == 0);
  CHECK(steps.straight[kUnknownCost] == 0);
}

TEST_CASE("Unknown cells count as what they are said to count as") {
  const StepCosts steps = make_step_costs({.allow_unknown = true, .unknown_as = 60});
  CHECK(steps.straight[kUnknownCost] == steps.straight[60]);
  CHECK(steps.diagonal[kUnknownCost] == steps.diagonal[60]);
  const StepCosts relief = make_relief_costs({});
  CHECK(relief.straight[kInscribedCost] > relief.straight[252]);
  CHECK(relief.diagonal[kInscribedCost] <= kMaxStepCost);
  CHECK(relief.straight[kLethalCost] == 0);
}
