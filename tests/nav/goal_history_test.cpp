// SPDX-License-Identifier: Apache-2.0
#include "nav/goal_history.hpp"

#include <catch2/catch.hpp>

using g3d::nav::GoalHistory;

TEST_CASE("Going back to a goal that was left a moment ago is noticed") {
  GoalHistory history;
  CHECK_FALSE(history.change({0, 0, 0}, {5, 0, 0}, 0));
  CHECK(history.change({5, 0, 0}, {0.2, 0.1, 1}, 1'000'000'000));
  CHECK(history.change({0.2, 0.1, 1}, {5, 0, 0}, 2'000'000'000));
}

TEST_CASE("Going on to new goals is not, and neither is turning to a goal anew after a long time") {
  GoalHistory history;
  for (int i = 0; i < 20; ++i) CHECK_FALSE(history.change({1.0 * i, 0, 0}, {1.0 * i + 1.0, 0, 0}, i));
  GoalHistory slow;
  CHECK_FALSE(slow.change({0, 0, 0}, {5, 0, 0}, 0));
  CHECK_FALSE(slow.change({5, 0, 0}, {0, 0, 0}, GoalHistory::kOfLate_ns + 1));
}

TEST_CASE("The same goal, moved a little, is no change") {
  GoalHistory history;
  CHECK_FALSE(history.change({0, 0, 0}, {0.3, 0, 0}, 0));
  CHECK_FALSE(history.change({0.3, 0, 0}, {0, 0, 0}, 1));
}
