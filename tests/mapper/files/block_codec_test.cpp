// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/block_codec.hpp"

#include <catch2/catch.hpp>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

TEST_CASE("A group of blocks comes back with keys, levels, colours and colour bits") {
  const auto map = tests::random_map(95, 700);
  const std::vector<BlockKey> keys = map->sorted_keys();
  BlockEncoder encoder;
  BlockDecoder decoder;
  for (int round = 0; round < 2; ++round) {  // working memory is used again
    const auto blocks = decoder.decode(encoder.encode(keys, *map));
    REQUIRE(blocks.ok());
    REQUIRE(blocks.value().size() == keys.size());
    BlockValues expected;
    for (std::size_t i = 0; i < keys.size(); ++i) {
      map->read_stored_block(keys[i], expected);
      REQUIRE(blocks.value()[i].key == keys[i]);
      REQUIRE(blocks.value()[i].values == expected);
    }
  }
}

TEST_CASE("A group may be empty, and a key that the map lacks is an unknown block") {
  const VoxelMap map(Grid{0.05F}, {8, 8, 8});
  BlockEncoder encoder;
  BlockDecoder decoder;
  CHECK(decoder.decode(encoder.encode({}, map)).value().empty());
  const std::vector<BlockKey> keys{(BlockKey{1} << 39) - 1};
  const auto blocks = decoder.decode(encoder.encode(keys, map));
  REQUIRE(blocks.ok());
  CHECK(blocks.value()[0].key == keys[0]);
  CHECK(blocks.value()[0].values[511] == kUnknownRgbo);
}

TEST_CASE("A furnished room takes less than a quarter of a byte per known voxel") {
  const auto map = tests::furnished_room(0.05F);
  const std::vector<BlockKey> keys = map->sorted_keys();
  REQUIRE(keys.size() <= kMaxGroupBlocks);
  BlockEncoder encoder;
  const double bytes = static_cast<double>(encoder.encode(keys, *map).size());
  CHECK(bytes / static_cast<double>(map->counts().known()) < 0.25);
}

TEST_CASE("Spoiled and cut groups are refused or decode to valid blocks, never more", "[long]") {
  const auto map = tests::random_map(96, 40);
  BlockEncoder encoder;
  const Bytes good = encoder.encode(map->sorted_keys(), *map);
  BlockDecoder decoder;
  for (std::size_t size = 0; size < good.size(); size += 1 + size / 40)
    CHECK_FALSE(decoder.decode(ByteSpan(good).first(size)).ok());
  tests::Random random(97);
  for (int i = 0; i < 500; ++i) {
    Bytes bad = good;
    bad[random.below(static_cast<std::uint32_t>(bad.size()))] ^= static_cast<std::uint8_t>(1 + random.below(255));
    const auto blocks = decoder.decode(bad);
    if (!blocks) continue;
    BlockKey last = 0;
    for (std::size_t b = 0; b < blocks.value().size(); ++b) {
      REQUIRE((b == 0 || blocks.value()[b].key > last));
      last = blocks.value()[b].key;
      REQUIRE(last < BlockKey{1} << 39);
      for (const Rgbo value : blocks.value()[b].values) REQUIRE(level_of(value) <= kMaxLevel);
    }
  }
}

TEST_CASE("Streams that claim more than a group can hold are refused before memory is taken") {
  const auto map = tests::random_map(98, 10);
  BlockEncoder encoder;
  Bytes bytes = encoder.encode(map->sorted_keys(), *map);
  const std::uint32_t huge = 0xFFFFFFFFU;
  std::memcpy(bytes.data(), &huge, 4);
  const auto blocks = BlockDecoder().decode(bytes);
  REQUIRE_FALSE(blocks.ok());
  CHECK(blocks.error().reason == hal::Reason::too_large);
}
