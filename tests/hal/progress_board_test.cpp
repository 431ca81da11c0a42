// SPDX-License-Identifier: Apache-2.0
#include "hal/progress_board.hpp"

#include <catch2/catch.hpp>

using namespace g3d::hal;

TEST_CASE("Who ticks or rests is not late", "[watchdog]") {
  ProgressBoard board;
  ProgressEntry& entry = board.add("base", 100);
  CHECK(board.find_late(0).name == nullptr);
  CHECK(board.find_late(10'000).name == nullptr);  // has not begun
  entry.tick();
  CHECK(board.find_late(10'100).name == nullptr);
  CHECK(board.find_late(10'200).name == nullptr);
  const auto late = board.find_late(10'201);
  REQUIRE(late.name != nullptr);
  CHECK(*late.name == "base");
  CHECK(late.since_ns == 10'100);
  entry.tick();
  CHECK(board.find_late(10'300).name == nullptr);
  entry.rest();
  CHECK(board.find_late(99'999).name == nullptr);
  entry.rest();
  entry.tick();
  CHECK(board.find_late(100'000).name == nullptr);
  CHECK(board.find_late(100'101).name != nullptr);
}

TEST_CASE("Of several that are late it is the one that is so for longest", "[watchdog]") {
  ProgressBoard board;
  ProgressEntry& slow = board.add("slow", 1'000);
  ProgressEntry& quick = board.add("quick", 100);
  slow.tick();
  quick.tick();
  (void)board.find_late(0);
  CHECK(*board.find_late(500).name == "quick");
  quick.tick();
  CHECK(board.find_late(1'000).name == nullptr);
  CHECK(*board.find_late(1'090).name == "slow");
  tick(nullptr);
  rest(nullptr);
}
