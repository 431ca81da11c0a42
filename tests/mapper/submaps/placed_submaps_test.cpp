// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/placed_submaps.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "mapper/map_hash.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;

namespace {

constexpr VoxelIndex kWall{32768 + 8, 32768, 32768};

void write(VoxelMap& map, const VoxelIndex& v, Rgbo code) {
  BlockValues values;
  map.read_stored_block(block_of(v), values);
  values[encode(v) & kPlaceMask] = code;
  REQUIRE(map.write_block(block_of(v), values));
}

Rgbo read(PlacedSubmaps& placed, const VoxelIndex& v) {
  BlockValues values;
  (void)placed.read_block(block_of(v), values);
  return values[encode(v) & kPlaceMask];
}

}  // namespace

TEST_CASE("the newest submap that knows a voxel says what it is, wherever it stands") {
  const Grid grid{0.05F};
  VoxelMap older(grid, {64, 64, 64});
  VoxelMap newer(grid, {64, 64, 64});
  write(older, kWall, 32);
  write(older, {kWall.x + 1, kWall.y, kWall.z}, 31);
  write(newer, {kWall.x + 2, kWall.y, kWall.z}, 4);
  PlacedSubmaps placed(grid);
  placed.add(older, {});
  placed.add(newer, hal::from_xyz_rpy(-0.1, 0, 0, 0, 0, 0));
  REQUIRE(placed.size() == 2);
  CHECK(read(placed, kWall) == 4);
  CHECK(read(placed, {kWall.x + 1, kWall.y, kWall.z}) == 31);
  BlockValues values;
  CHECK_FALSE(placed.read_block(block_of({kWall.x + 800, kWall.y, kWall.z}), values));

  const auto keys = placed.keys();
  CHECK(std::is_sorted(keys.begin(), keys.end()));
  CHECK(std::adjacent_find(keys.begin(), keys.end()) == keys.end());
  CHECK(keys.size() <= placed.keys_of(0).size() + placed.keys_of(1).size());
  CHECK(placed.memory_bytes() > 0);
}

TEST_CASE("as a whole they are what they are block by block") {
  const Grid grid{0.05F};
  VoxelMap older(grid, {256, 256, 256});
  VoxelMap newer(grid, {256, 256, 256});
  for (int i = 0; i < 40; ++i) {
    write(older, {kWall.x + 3 * i, kWall.y + i, kWall.z}, 20);
    write(newer, {kWall.x + 3 * i, kWall.y, kWall.z + i % 5}, 8);
  }
  PlacedSubmaps placed(grid);
  placed.add(older, hal::from_xyz_rpy(0.4, 0.1, 0, 0, 0, 0.3));
  placed.add(newer, hal::from_xyz_rpy(-0.2, 0, 0, 0, 0, -0.1));
  const std::unique_ptr<VoxelMap> whole = placed.whole();
  std::size_t known = 0;
  BlockValues a;
  BlockValues b;
  for (const BlockKey key : placed.keys()) {
    CHECK(placed.read_block(key, a) == whole->read_stored_block(key, b));
    CHECK(a == b);
    known += static_cast<std::size_t>(
        std::count_if(a.begin(), a.end(), [](Rgbo v) { return state_of(v) != State::unknown; }));
  }
  CHECK(known == whole->counts().known());
  CHECK(known > 40);
}
