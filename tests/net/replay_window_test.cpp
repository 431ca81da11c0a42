// SPDX-License-Identifier: Apache-2.0
#include "net/replay_window.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <set>

namespace {

using namespace g3d::net;

TEST_CASE("each counter is fresh once, in order") {
  ReplayWindow window;
  window.begin_at(0);
  for (std::uint64_t i = 1; i < 5000; ++i) REQUIRE(window.take(i) == Freshness::fresh);
  for (std::uint64_t i = 0; i < 5000; ++i) {
    REQUIRE(window.take(i) == (i + 1024 <= 4999 ? Freshness::too_old : Freshness::replayed));
  }
}

TEST_CASE("nothing from before the beginning is fresh") {
  for (const std::uint64_t first : {0U, 1U, 63U, 1023U, 1024U, 1'000'000U}) {
    ReplayWindow window;
    window.begin_at(first);
    for (std::uint64_t back = 0; back <= std::min<std::uint64_t>(first, 2000); ++back) {
      REQUIRE(window.take(first - back) == (back < 1024 ? Freshness::replayed : Freshness::too_old));
    }
    CHECK(window.take(first + 1) == Freshness::fresh);
    if (first > 0) CHECK(window.take(first - 1) == Freshness::replayed);
  }
}

TEST_CASE("1023 behind is in the window, 1024 is not") {
  ReplayWindow window;
  window.begin_at(10);
  CHECK(window.take(2000) == Freshness::fresh);
  CHECK(window.take(2000 - 1023) == Freshness::fresh);
  CHECK(window.take(2000 - 1023) == Freshness::replayed);
  CHECK(window.take(2000 - 1024) == Freshness::too_old);
}

TEST_CASE("jumps of any width forget what they pass") {
  for (const std::uint64_t jump : {1U, 2U, 63U, 64U, 65U, 1022U, 1023U, 1024U, 1025U, 5000U}) {
    ReplayWindow window;
    window.begin_at(3000);
    REQUIRE(window.take(3000 + jump) == Freshness::fresh);
    for (std::uint64_t back = 1; back < 1024; ++back) {
      REQUIRE(window.take(3000 + jump - back) == (back < jump ? Freshness::fresh : Freshness::replayed));
    }
  }
}

TEST_CASE("the window agrees with a list of all that was seen") {
  std::mt19937_64 random(1);
  ReplayWindow window;
  window.begin_at(1);
  std::set<std::uint64_t> seen{0, 1};
  std::uint64_t highest = 1;
  for (int i = 0; i < 100'000; ++i) {
    const std::uint64_t ahead = random() % 1000 == 0 ? random() % 3000 : random() % 3;
    const std::uint64_t counter = highest + ahead - std::min<std::uint64_t>(highest, random() % 1100);
    Freshness expected = Freshness::fresh;
    if (counter + 1024 <= highest) {
      expected = Freshness::too_old;
    } else if (seen.count(counter) != 0) {
      expected = Freshness::replayed;
    }
    REQUIRE(window.take(counter) == expected);
    seen.insert(counter);
    highest = std::max(highest, counter);
    REQUIRE(window.highest() == highest);
  }
}

TEST_CASE("the last counter of all is taken") {
  ReplayWindow window;
  window.begin_at((std::uint64_t{1} << 40) - 2);
  CHECK(window.take((std::uint64_t{1} << 40) - 1) == Freshness::fresh);
  CHECK(window.take((std::uint64_t{1} << 40) - 1) == Freshness::replayed);
}

}  // namespace
