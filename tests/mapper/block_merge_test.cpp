// SPDX-License-Identifier: Apache-2.0
#include "mapper/block_merge.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "mapper/merge.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

TEST_CASE("levels add up around unknown, colours come from who is surer", "[mapper][paging]") {
  const Rgbo red = make_rgbo(255, 0, 0, 20) | kHasColourBit;
  const Rgbo blue = make_rgbo(0, 0, 255, 24) | kHasColourBit;
  CHECK(merged_value(kUnknownRgbo, red) == red);
  CHECK(merged_value(red, kUnknownRgbo) == red);
  CHECK(merged_value(red, blue) == (make_rgbo(0, 0, 255, 28) | kHasColourBit));
  CHECK(merged_value(blue, red) == (make_rgbo(0, 0, 255, 28) | kHasColourBit));
  CHECK(merged_value(red, 2) == 6);   // no longer occupied: no colour
  CHECK(merged_value(0, 0) == 0);     // clamped
  CHECK(merged_value(32, 32) == 32);  // clamped
  CHECK(merged_value(10, red) == 14);
  CHECK(merged_value(30, red) == (make_rgbo(255, 0, 0, 32) | kHasColourBit));  // the only colour there is
}

TEST_CASE("merging blocks is merging maps", "[mapper][paging]") {
  const auto older = tests::random_map(1, 300);
  const auto newer = tests::random_map(2, 300);
  // merge_maps() prefers the lower layer on a tie: the older one.
  const std::vector<MergeSource> sources{{older.get(), {}, 1}, {newer.get(), {}, 2}};
  const auto merged = merge_maps(sources);
  REQUIRE(merged.ok());
  BlockValues a;
  BlockValues b;
  BlockValues expected;
  int compared = 0;
  for (const BlockKey key : newer->sorted_keys()) {
    if (!older->read_stored_block(key, a)) continue;
    newer->read_stored_block(key, b);
    merge_into(b, a);
    merged.value()->read_stored_block(key, expected);
    CHECK(
        std::equal(b.begin(), b.end(), expected.begin(), [](Rgbo x, Rgbo y) { return published(x) == published(y); }));
    ++compared;
  }
  CHECK(compared > 20);
}

TEST_CASE("lists are merged by key", "[mapper][paging]") {
  const auto block = [](BlockKey key, Rgbo value) {
    StoredBlock stored;
    stored.key = key;
    stored.values.fill(value);
    return stored;
  };
  const std::vector<StoredBlock> older{block(1, 10), block(3, 10), block(5, 10)};
  const std::vector<StoredBlock> newer{block(0, 12), block(3, 12), block(9, 12)};
  std::vector<StoredBlock> out(6);
  REQUIRE(merge_lists(older, newer, out) == 5);
  const std::vector<std::pair<BlockKey, Rgbo>> expected{{0, 12}, {1, 10}, {3, 6}, {5, 10}, {9, 12}};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    CHECK(out[i].key == expected[i].first);
    CHECK(out[i].values[17] == expected[i].second);
  }
  CHECK(merge_lists({}, {}, out) == 0);
}
