// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/mirror.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "mapper/map_hash.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::cuda;

namespace {

constexpr std::uint32_t kRoom = 8;

struct ParcelMemory {
  std::vector<ParcelHead> heads{kRoom};
  std::vector<ParcelPlane> planes{kRoom};
  std::vector<ParcelBrick> bricks{std::size_t{kRoom} * kBricks};
  Parcels parcels{heads.data(), planes.data(), bricks.data()};
};

/// A block of any form: wholly unknown, uniform, dense, with colours in some bricks.
BlockValues random_block(tests::Random& random) {
  BlockValues values;
  const std::uint32_t form = random.below(4);
  const Rgbo level = random.below(16);
  values.fill(form == 0 ? kUnknownRgbo : level);
  for (std::size_t i = 0; i < values.size() && form >= 2; ++i) {
    if (random.below(3) == 0) values[i] = random.below(33);
    const bool coloured = form == 3 && i / kBrickVoxels % 3 == 0 && random.below(4) == 0;
    if (coloured) values[i] = make_rgbo(static_cast<std::uint8_t>(random.below(256)), 7, 9, 20) | kHasColourBit;
  }
  return values;
}

}  // namespace

TEST_CASE("blocks of every form pass from one map to another by parcel, over whatever was there") {
  const MapCapacity capacity{64, 32, 128};
  VoxelMap from(Grid{0.05F}, capacity);
  VoxelMap to(Grid{0.05F}, capacity);
  ParcelMemory memory;
  tests::Random random(3);
  for (int round = 0; round < 300; ++round) {
    const BlockKey key = random.below(12);
    REQUIRE(from.write_block(key, random_block(random)));
    const std::uint32_t index = random.below(kRoom);
    REQUIRE(make_parcel(from, key, memory.parcels, index));
    const auto [slot, complete] = take_parcel(to, memory.parcels, index, 5);
    REQUIRE(slot == to.find(key));
    REQUIRE(complete);
    CHECK(to.header(slot).changed_frame == 5);
    REQUIRE(map_hash(to) == map_hash(from));
    CHECK(to.memory().used_bytes == from.memory().used_bytes);
  }
}

TEST_CASE("of a block that is not in the map there is no parcel") {
  const VoxelMap map(Grid{0.05F}, {16, 16, 16});
  ParcelMemory memory;
  memory.heads[2].key = 5;
  CHECK_FALSE(make_parcel(map, 77, memory.parcels, 2));
  CHECK(memory.heads[2].key == 5);
}

TEST_CASE("a full map refuses a parcel and says so") {
  VoxelMap from(Grid{0.05F}, {16, 16, 16});
  VoxelMap to(Grid{0.05F}, {1, 0, 0});
  ParcelMemory memory;
  BlockValues values;
  values.fill(3);
  REQUIRE(from.write_block(1, values));
  values[7] = 30;
  REQUIRE(from.write_block(2, values));
  REQUIRE(make_parcel(from, 2, memory.parcels, 0));
  CHECK(take_parcel(to, memory.parcels, 0, 1).slot == kNoSlot);  // no plane left
  CHECK(to.block_count() == 0);
  REQUIRE(make_parcel(from, 1, memory.parcels, 0));
  const Taken first = take_parcel(to, memory.parcels, 0, 1);
  CHECK((first.slot != kNoSlot && first.complete));
  CHECK(to.at(std::uint64_t{1} << 9) == 3);
  values.fill(9);
  REQUIRE(from.write_block(3, values));
  REQUIRE(make_parcel(from, 3, memory.parcels, 0));
  CHECK(take_parcel(to, memory.parcels, 0, 1).slot == kNoSlot);  // no block left
}

TEST_CASE("a map that is full of colours takes the levels alone") {
  VoxelMap from(Grid{0.05F}, {16, 16, 16});
  VoxelMap to(Grid{0.05F}, {16, 16, 1});
  ParcelMemory memory;
  BlockValues values;
  values.fill(3);
  for (const std::size_t place : {5U, 6U, 200U}) values[place] = make_rgbo(90, 80, 70, 20) | kHasColourBit;
  REQUIRE(from.write_block(1, values));
  REQUIRE(make_parcel(from, 1, memory.parcels, 0));
  const Taken taken = take_parcel(to, memory.parcels, 0, 1);
  REQUIRE(taken.slot != kNoSlot);
  CHECK_FALSE(taken.complete);
  BlockValues got;
  REQUIRE(to.read_block(1, got));
  CHECK(got[5] == make_rgbo(90, 80, 70, 20));  // the one brick that there is
  CHECK(got[200] == make_rgbo(0, 0, 0, 20));
  // And what it says of itself is what a map with room says of it.
  REQUIRE(make_parcel(to, 1, memory.parcels, 0));
  REQUIRE(take_parcel(from, memory.parcels, 0, 2).complete);
  CHECK(map_hash(from) == map_hash(to));
}
