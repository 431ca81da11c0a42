// SPDX-License-Identifier: Apache-2.0
#include "net/symbol_walk.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <vector>

#include "hal/sim/seeded_random.hpp"

using namespace g3d;
using namespace g3d::net;

TEST_CASE("a walk is the same on every machine", "[net][sketch]") {
  std::vector<std::uint32_t> walk;
  for_each_symbol_of(0x0123456789ABCDEFULL, 0, 100000, [&](std::uint32_t i) { walk.push_back(i); });
  CHECK(walk == std::vector<std::uint32_t>{0,    1,     3,     7,     9,     20,    27,    46,   55,
                                           334,  475,   964,   1090,  1471,  1530,  2256,  2795, 7294,
                                           8718, 14306, 22531, 30150, 32739, 47192, 59945, 88555});
  // All of 20000 walks, to the last index there is.
  std::uint64_t digest = 0;
  for (std::uint64_t n = 0; n < 20000; ++n) {
    for_each_symbol_of(sketch_mix(n), 0, kMostSketchSymbols, [&](std::uint32_t i) { digest = sketch_mix(digest + i); });
  }
  CHECK(digest == 0xAC66168A1396E9A7ULL);
}

TEST_CASE("a walk may start anywhere, ascends and has the density that it should", "[net][sketch]") {
  constexpr std::uint32_t kEnd = 700;
  constexpr int kItems = 40000;
  hal::SeededRandom random(7);
  std::vector<int> visits(kEnd);
  for (int n = 0; n < kItems; ++n) {
    const SketchId id = random.bits();
    std::vector<std::uint32_t> whole, parts;
    for_each_symbol_of(id, 0, kEnd, [&](std::uint32_t i) { whole.push_back(i); });
    REQUIRE(std::ranges::adjacent_find(whole, std::greater_equal<>()) == whole.end());
    for (const std::uint32_t i : whole) ++visits[i];
    if (n % 64 != 0) continue;
    for (std::uint32_t first = 0, step = 1; first < kEnd; first += step++) {
      for_each_symbol_of(id, first, std::min(first + step, kEnd), [&](std::uint32_t i) { parts.push_back(i); });
    }
    REQUIRE(parts == whole);
  }
  for (std::uint32_t i = 0; i < kEnd; ++i) {
    const double density =
        static_cast<double>(symbol_density(i).numerator) / static_cast<double>(symbol_density(i).denominator);
    const double sigma = std::sqrt(kItems * density * (1.0 - density));
    INFO("symbol " << i);
    CHECK(std::abs(visits[i] - kItems * density) <= 4.5 * sigma);
  }
}
