// SPDX-License-Identifier: Apache-2.0
#include "net/level_classes.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

using namespace g3d;
using namespace g3d::net;

TEST_CASE("Every level is of the sort its state says, and so many steps from saturation") {
  for (std::uint8_t level = 0; level <= mapper::kMaxLevel; ++level) {
    const mapper::State state = mapper::state_of_level(level);
    const auto& c = kLevelClasses;
    REQUIRE(c.sort[level] == (state == mapper::State::free ? 1 : state == mapper::State::occupied ? 2 : 0));
    REQUIRE(c.three[level] == (state == mapper::State::unknown ? 1 : 2));
    const int steps = state == mapper::State::free       ? level / 2
                      : state == mapper::State::occupied ? (32 - level) / 2
                                                         : 8;
    REQUIRE(c.steps[level] == steps);
    REQUIRE(c.four[level] < 4);
    REQUIRE(c.five[level] < 5);
    REQUIRE(c.surface[level] < 5);
  }
  CHECK(kLevelClasses.steps[kNoLevel] == 8);
  CHECK(kLevelClasses.three[kNoLevel] == 0);
}

TEST_CASE("Triples have one rank in whatever order, and all ranks are used") {
  std::set<int> ranks;
  for (std::size_t a = 0; a < 9; ++a) {
    for (std::size_t b = 0; b < 9; ++b) {
      for (std::size_t c = 0; c < 9; ++c) {
        std::array<std::size_t, 3> sorted{a, b, c};
        std::sort(sorted.begin(), sorted.end());
        const int rank = kTripleRanks.rank[a * 81 + b * 9 + c];
        REQUIRE(rank == kTripleRanks.rank[sorted[0] * 81 + sorted[1] * 9 + sorted[2]]);
        ranks.insert(rank);
      }
    }
  }
  CHECK(ranks.size() == 165);
  CHECK(*ranks.rbegin() == 164);
}
