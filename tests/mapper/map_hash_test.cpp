// SPDX-License-Identifier: Apache-2.0
#include "mapper/map_hash.hpp"

#include <sodium.h>

#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/sample_maps.hpp"

using namespace g3d::mapper;
using g3d::tests::Random;

namespace {

/// BLAKE2b-256 over a plain list of numbers, put together voxel by voxel.
std::string slow_hash(const VoxelMap& map) {
  std::vector<std::uint8_t> bytes;
  const auto append = [&](std::uint64_t value, int count) {
    for (int i = 0; i < count; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  };
  for (const BlockKey key : map.sorted_keys()) {
    append(key, 8);
    for (MCode place = 0; place < kBlockVoxels; ++place) append(map.at((key << kBlockShift) | place), 4);
  }
  std::uint8_t digest[32];
  crypto_generichash(digest, sizeof digest, bytes.data(), bytes.size(), nullptr, 0);
  char hex[65];
  sodium_bin2hex(hex, sizeof hex, digest, sizeof digest);
  return hex;
}

/// Colours and levels that vary with the place.
BlockValues ramp() {
  BlockValues values;
  for (std::uint32_t i = 0; i < kBlockVoxels; ++i) {
    const std::uint32_t level = i % 33;
    values[i] =
        level <= 16 ? level : ((i * 7 + 1) % 256) << 24 | ((i * 5 + 2) % 256) << 16 | ((i * 3 + 3) % 256) << 8 | level;
  }
  return values;
}

}  // namespace

// The constants were computed apart from this program, with Python's hashlib.
TEST_CASE("hand-built maps have their golden hashes") {
  VoxelMap map(Grid{0.05F}, {16, 16, 64});
  CHECK(map_hash(map) == "0e5751c026e543b2e8ab2eb06099daa1d1e5df47778f7787faab45cdf12fe3a8");
  SECTION("one voxel") {
    const MCode code = encode({32794, 32808, 32776});
    BlockValues values;
    values.fill(kUnknownRgbo);
    values[code & kPlaceMask] = make_rgbo(1, 2, 3, 20);
    REQUIRE(map.write_block(code >> kBlockShift, values));
    CHECK(map_hash(map) == "c2798c0fcb0afccca4383217f327950ca78e0d472f6a60c8bfe2eb3709debd97");
  }
  SECTION("three blocks at both ends of the grid") {
    BlockValues values;
    values.fill(32);
    REQUIRE(map.write_block((BlockKey{1} << 39) - 1, values));
    REQUIRE(map.write_block(12345678901, ramp()));
    values.fill(0);
    REQUIRE(map.write_block(0, values));
    CHECK(map_hash(map) == "806cf4a4176b7f956326ea331b9ff85e626df430e5ba7e74b4ef2b5d68f66660");
  }
}

TEST_CASE("the hash is that of the serialised map") {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto map = g3d::tests::random_map(seed, 60);
    CHECK(map_hash(*map) == slow_hash(*map));
  }
}

TEST_CASE("neither the order of insertion nor what was erased nor how memory lies shows in the hash") {
  Random random(5);
  const auto source = g3d::tests::random_map(9, 80);
  const std::string expected = map_hash(*source);
  std::vector<BlockKey> keys = source->sorted_keys();
  for (int round = 0; round < 5; ++round) {
    for (std::size_t i = keys.size() - 1; i > 0; --i)
      std::swap(keys[i], keys[random.below(static_cast<std::uint32_t>(i + 1))]);
    VoxelMap copy(source->grid(), {512, 512, 4096});
    BlockValues values;
    values.fill(5);
    for (BlockKey extra = 1000; extra < 1100; ++extra) REQUIRE(copy.write_block(extra, values));
    for (const BlockKey key : keys) {
      source->read_stored_block(key, values);
      REQUIRE(copy.write_block(key, values));
      (void)copy.make_dense(copy.header(copy.find(key)));
    }
    for (BlockKey extra = 1000; extra < 1100; ++extra) {
      if (source->find(extra) == kNoSlot) copy.erase_block(extra);
    }
    (void)copy.find_or_insert(77777);  // a block in which nothing is known is no block
    CHECK(map_hash(copy) == expected);
  }
}

TEST_CASE("the hash sees levels, colours and places, but not colours of voxels that are not occupied") {
  VoxelMap map(Grid{}, {8, 8, 64});
  BlockValues values = ramp();
  REQUIRE(map.write_block(5, values));
  const std::string before = map_hash(map);
  values[0] = make_rgbo(200, 0, 0, 0);
  REQUIRE(map.write_block(5, values));
  CHECK(map_hash(map) == before);
  values[0] = 1;
  REQUIRE(map.write_block(5, values));
  CHECK(map_hash(map) != before);
  values = ramp();
  values[20] ^= 1U << 24;
  REQUIRE(map.write_block(5, values));
  CHECK(map_hash(map) != before);
  map.clear();
  REQUIRE(map.write_block(6, ramp()));
  CHECK(map_hash(map) != before);
}
