// SPDX-License-Identifier: Apache-2.0
#include "mapper/block_source.hpp"

#include <catch2/catch.hpp>

#include "mapper/map_hash.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

TEST_CASE("a map in memory is visited region by region, in order, whole", "[mapper][paging]") {
  const auto map = tests::random_map(3, 2000);
  std::vector<BlockKey> keys;
  BlockValues values;
  const auto done = MemoryBlocks(*map).visit_regions([&](std::span<const StoredBlock> blocks) {
    REQUIRE_FALSE(blocks.empty());
    if (!keys.empty()) CHECK(region_of(keys.back()) < region_of(blocks.front().key));
    for (const StoredBlock& block : blocks) {
      CHECK(region_of(block.key) == region_of(blocks.front().key));
      map->read_stored_block(block.key, values);
      CHECK(values == block.values);
      keys.push_back(block.key);
    }
    return hal::Result<void>{};
  });
  CHECK(done.ok());
  CHECK(keys == map->sorted_keys());
}

TEST_CASE("a failure ends the visit", "[mapper][paging]") {
  const auto map = tests::random_map(4, 500);
  int visits = 0;
  const auto done = MemoryBlocks(*map).visit_regions([&](std::span<const StoredBlock>) -> hal::Result<void> {
    if (++visits == 2) return hal::Error{hal::Reason::disk_full, "no room"};
    return {};
  });
  CHECK(visits == 2);
  CHECK(done.error().text == "no room");
}

TEST_CASE("measuring agrees with the map's own counts and suffices to hold it", "[mapper][paging]") {
  const auto map = tests::random_map(5, 1000);
  const auto size = measure(MemoryBlocks(*map));
  REQUIRE(size.ok());
  MapCounts known = map->counts();
  const std::uint64_t unknown_blocks = known.blocks - map->sorted_keys().size();  // these are uniform
  known.blocks -= unknown_blocks;
  known.uniform_blocks -= unknown_blocks;
  CHECK((size.value().counts == known));
  VoxelMap copy(map->grid(), size.value().needed);
  BlockValues values;
  for (const BlockKey key : map->sorted_keys()) {
    map->read_stored_block(key, values);
    REQUIRE(copy.write_block(key, values));
  }
  CHECK(map_hash(copy) == map_hash(*map));
  CHECK(copy.available().planes == 0);
  CHECK(copy.available().colour_bricks == 0);
}

TEST_CASE("known is what has one known voxel", "[mapper][paging]") {
  BlockValues values;
  values.fill(kUnknownRgbo);
  CHECK_FALSE(is_known(values));
  values[511] = 0;
  CHECK(is_known(values));
}
