// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/placed_submaps.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "mapper/map_hash.hpp"
#include "tests/support/memory_page_file.hpp"
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

ShelvedContents contents_of(std::unique_ptr<VoxelMap> voxels) {
  return ShelvedContents({std::move(voxels), {}, nullptr});
}

Rgbo read(PlacedSubmaps& placed, const VoxelIndex& v) {
  BlockValues values;
  (void)placed.read_block(block_of(v), values);
  return values[encode(v) & kPlaceMask];
}

}  // namespace

TEST_CASE("the newest submap that knows a voxel says what it is, wherever it stands") {
  const Grid grid{0.05F};
  auto older_voxels = map_for_blocks(grid, 64);
  auto newer_voxels = map_for_blocks(grid, 64);
  write(*older_voxels, kWall, 32);
  write(*older_voxels, {kWall.x + 1, kWall.y, kWall.z}, 31);
  write(*newer_voxels, {kWall.x + 2, kWall.y, kWall.z}, 4);
  ShelvedContents older = contents_of(std::move(older_voxels));
  ShelvedContents newer = contents_of(std::move(newer_voxels));
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
  auto older_voxels = map_for_blocks(grid, 256);
  auto newer_voxels = map_for_blocks(grid, 256);
  for (int i = 0; i < 40; ++i) {
    write(*older_voxels, {kWall.x + 3 * i, kWall.y + i, kWall.z}, 20);
    write(*newer_voxels, {kWall.x + 3 * i, kWall.y, kWall.z + i % 5}, 8);
  }
  ShelvedContents older = contents_of(std::move(older_voxels));
  ShelvedContents newer = contents_of(std::move(newer_voxels));
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

TEST_CASE("each region lists its own blocks, and how far a submap is from anywhere is that of its nearest region") {
  const Grid grid{0.05F};
  auto here_voxels = map_for_blocks(grid, 8);
  auto there_voxels = map_for_blocks(grid, 8);
  write(*here_voxels, kWall, 32);
  write(*here_voxels, {kWall.x, kWall.y + 200, kWall.z}, 32);
  write(*there_voxels, {kWall.x + 280, kWall.y, kWall.z}, 32);
  ShelvedContents here = contents_of(std::move(here_voxels));
  ShelvedContents there = contents_of(std::move(there_voxels));
  ShelvedContents nothing = contents_of(map_for_blocks(grid, 0));
  PlacedSubmaps placed(grid);
  placed.add(here, {});
  placed.add(there, hal::from_xyz_rpy(0.5, 0.0, 0.0, 0.0, 0.0, 0.0));  // ten voxels
  placed.add(nothing, {});

  const auto regions = placed.regions();
  REQUIRE(regions.size() == 3);
  CHECK(std::is_sorted(regions.begin(), regions.end()));
  std::vector<BlockKey> all;
  for (const RegionKey region : regions) {
    for (const BlockKey key : placed.keys_in(region)) {
      CHECK(region_of(key) == region);
      all.push_back(key);
    }
  }
  CHECK(all == placed.keys());
  CHECK(placed.keys_in(region_of({kWall.x + 600, kWall.y, kWall.z})).empty());

  // From the wall: its own region, and the near face of the one 290 voxels on.
  const VoxelIndex near_face = region_origin(region_of({kWall.x + 290, kWall.y, kWall.z}));
  CHECK(placed.squared_distance_cells(0, kWall) == 0);
  CHECK(placed.squared_distance_cells(1, kWall) ==
        std::int64_t{near_face.x - kWall.x} * std::int64_t{near_face.x - kWall.x});
  CHECK(placed.squared_distance_cells(2, kWall) == std::numeric_limits<std::int64_t>::max());
}

TEST_CASE("a submap that lies on the shelf is fetched when somebody asks for a block of it") {
  const Grid grid{0.05F};
  SubmapShelf shelf(std::make_unique<tests::MemoryPageFile>());
  auto voxels = map_for_blocks(grid, 8);
  write(*voxels, kWall, 32);
  ShelvedContents contents({std::move(voxels), {}, nullptr}, &shelf);
  contents.put_away();
  PlacedSubmaps placed(grid);
  placed.add(contents, {});
  CHECK(placed.keys() == std::vector{block_of(kWall)});
  CHECK_FALSE(contents.is_in_memory());
  CHECK(read(placed, kWall) == 32);
  CHECK(contents.is_in_memory());
  contents.put_away();
  CHECK(read(placed, kWall) == 32);  // from another place in memory
}
