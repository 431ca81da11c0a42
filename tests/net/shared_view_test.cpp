// SPDX-License-Identifier: Apache-2.0
#include "net/shared_view.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "mapper/block_merge.hpp"
#include "mapper/block_source.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;

TEST_CASE("the shared view is the own map with what the others have seen, block by block as they change", "[net]") {
  const auto seed_map = tests::random_map(1, 60, 0.1F);
  // Room for what both know.
  const auto own =
      std::make_unique<mapper::VoxelMap>(seed_map->grid(), mapper::MapCapacity{1U << 10, 1U << 10, 1U << 12});
  for (const mapper::BlockKey key : seed_map->sorted_keys()) {
    mapper::BlockValues values{};
    (void)seed_map->read_stored_block(key, values);
    REQUIRE(own->write_block(key, values));
  }
  const auto others = tests::random_map(2, 60, 0.1F);
  net::SharedView view(*own, *others);
  // Own blocks and others' come in any order; each block of the view is then what both say of it.
  std::vector<mapper::BlockKey> keys = others->sorted_keys();
  for (std::uint32_t slot = 0; slot < own->slot_end(); ++slot) {
    CHECK(view.on_own(*own, std::array{slot}).size() <= 1);
    if (slot < keys.size()) (void)view.on_others(std::array{keys[slot]});
  }
  (void)view.on_others(keys);
  CHECK(view.refused_blocks() == 0);
  for (const mapper::BlockKey key : own->sorted_keys()) keys.push_back(key);
  mapper::BlockValues expected{};
  mapper::BlockValues older{};
  mapper::BlockValues seen{};
  for (const mapper::BlockKey key : keys) {
    if (!own->read_stored_block(key, expected)) expected.fill(mapper::kUnknownRgbo);
    if (others->read_stored_block(key, older)) mapper::merge_into(expected, older);
    (void)view.map().read_stored_block(key, seen);
    REQUIRE(seen == expected);
  }
}

TEST_CASE("what nobody knows any more leaves the shared view", "[net]") {
  const mapper::VoxelMap empty(mapper::Grid{0.1F}, {64, 64, 64});
  const auto* own = &empty;
  const auto others = tests::furnished_room(0.1F);
  net::SharedView view(*own, *others);
  mapper::BlockKey alone = 0;
  for (const mapper::BlockKey key : others->sorted_keys()) {
    if (own->find(key) == mapper::kNoSlot) alone = key;
  }
  REQUIRE(view.on_others(std::array{alone}).size() == 1);
  const std::uint32_t slot = view.map().find(alone);
  REQUIRE(slot != mapper::kNoSlot);
  REQUIRE(others->erase_block(alone));
  const auto changed = view.on_others(std::array{alone});
  REQUIRE(changed.size() == 1);
  CHECK(changed[0] == slot);
  CHECK(view.map().find(alone) == mapper::kNoSlot);
  CHECK(view.on_others(std::array{alone}).empty());
}

TEST_CASE("an own block that moves from slot to slot leaves no copy of itself in the shared view", "[net]") {
  mapper::VoxelMap own(mapper::Grid{0.1F}, {64, 64, 64});
  const mapper::VoxelMap nobody(mapper::Grid{0.1F}, {64, 64, 64});
  net::SharedView view(own, nobody);
  mapper::BlockValues values;
  values.fill(30);
  const mapper::BlockKey before = mapper::block_of({32768, 32768, 32768});
  const mapper::BlockKey after = mapper::block_of({32776, 32768, 32768});
  REQUIRE(own.write_block(before, values));
  const std::uint32_t slot = own.find(before);
  (void)view.on_own(own, std::array{slot});
  REQUIRE(own.erase_block(before));
  REQUIRE(own.write_block(after, values));
  REQUIRE(own.find(after) == slot);  // as when a loop moves the map
  CHECK(view.on_own(own, std::array{slot}).size() == 2);
  CHECK(view.map().sorted_keys() == std::vector{after});
  REQUIRE(own.erase_block(after));
  CHECK(view.on_own(own, std::array{slot}).size() == 1);
  CHECK(view.map().sorted_keys().empty());
}
