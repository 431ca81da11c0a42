// SPDX-License-Identifier: Apache-2.0
#include "mapper/fixed_table.hpp"

#include <catch2/catch.hpp>
#include <unordered_map>

#include "tests/support/sample_maps.hpp"

using namespace g3d;

TEST_CASE("a fixed table does what std::unordered_map does, until it is full", "[mapper][paging]") {
  const std::uint32_t capacity = GENERATE(1U, 7U, 100U);
  tests::Random random(capacity);
  mapper::FixedTable<int> table(capacity);
  std::unordered_map<std::uint64_t, int> plain;
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t key = random.below(2 * capacity) * 0x100000ULL;
    if (random.below(2) == 0) {
      int* value = table.find_or_insert(key);
      REQUIRE((value != nullptr) == (plain.contains(key) || plain.size() < capacity));
      if (value != nullptr) {
        CHECK(*value == plain[key]);  // zero if it is new
        *value = plain[key] = i;
      }
    } else {
      REQUIRE(table.erase(key) == (plain.erase(key) > 0));
    }
    REQUIRE(table.size() == plain.size());
  }
  for (std::uint64_t k = 0; k < 2 * capacity; ++k) {
    const int* value = table.find(k * 0x100000ULL);
    REQUIRE((value != nullptr) == plain.contains(k * 0x100000ULL));
    if (value != nullptr) CHECK(*value == plain[k * 0x100000ULL]);
  }
  std::size_t visited = 0;
  table.for_each([&](std::uint64_t key, int value) {
    CHECK(plain.at(key) == value);
    ++visited;
  });
  CHECK(visited == plain.size());
}
