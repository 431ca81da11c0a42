// SPDX-License-Identifier: Apache-2.0
#include "mapper/region.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

TEST_CASE("a region holds the 512 blocks of its cube", "[mapper][paging]") {
  const RegionKey region = region_of(VoxelIndex{32768, 32768, 32704});
  const VoxelIndex low = region_origin(region);
  CHECK(low == VoxelIndex{32768, 32768, 32704});
  for (BlockKey key = first_block(region); key < first_block(region + 1); ++key) {
    const VoxelIndex v = block_origin(key);
    CHECK(region_of(key) == region);
    CHECK((v.x - low.x < 64 && v.y - low.y < 64 && v.z - low.z < 64 && v.x >= low.x && v.y >= low.y && v.z >= low.z));
  }
}

TEST_CASE("the distance to a region is that to its nearest voxel", "[mapper][paging]") {
  tests::Random random(1);
  for (int i = 0; i < 20; ++i) {
    const VoxelIndex low{static_cast<int>(random.below(4)) * 64, static_cast<int>(random.below(4)) * 64, 64};
    const VoxelIndex from{static_cast<int>(random.below(300)), static_cast<int>(random.below(300)),
                          static_cast<int>(random.below(300))};
    std::int64_t nearest = 1 << 30;
    for (int z = 0; z < 64; ++z) {
      for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) {
          const std::int64_t dx = low.x + x - from.x;
          const std::int64_t dy = low.y + y - from.y;
          const std::int64_t dz = low.z + z - from.z;
          nearest = std::min(nearest, dx * dx + dy * dy + dz * dz);
        }
      }
    }
    CHECK(squared_distance_cells(region_of(low), from) == nearest);
  }
}

TEST_CASE("a box of regions holds those that its voxels are in, and visits each once", "[mapper][paging]") {
  const VoxelIndex low{63, 64, 130};
  const VoxelIndex high{64, 127, 200};
  const RegionBox box(low, high);
  std::vector<RegionKey> visited;
  box.for_each([&](RegionKey region) { visited.push_back(region); });
  std::vector<RegionKey> expected;
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) expected.push_back(region_of(VoxelIndex{x, y, z}));
    }
  }
  std::sort(expected.begin(), expected.end());
  expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
  std::sort(visited.begin(), visited.end());
  CHECK(visited == expected);
  CHECK(visited.size() == 4);
  for (int z = 0; z < 320; z += 32) {
    for (int y = 0; y < 320; y += 32) {
      for (int x = 0; x < 320; x += 32) {
        const RegionKey region = region_of(VoxelIndex{x, y, z});
        CHECK(box.holds(region) == std::binary_search(expected.begin(), expected.end(), region));
      }
    }
  }
}
