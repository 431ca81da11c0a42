// SPDX-License-Identifier: Apache-2.0
#include "nav/column_evidence.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using namespace g3d::nav;

namespace {

// Evidence of the cell below (x, y, z) when that voxel alone has this level.
Evidence of_voxel(float resolution_m, float z_m, std::uint8_t level,
                  std::uint8_t second_level = mapper::kUnknownLevel) {
  mapper::VoxelMap map({resolution_m}, {64, 64, 64});
  const mapper::VoxelIndex at = map.grid().to_index(0.001F, 0.001F, z_m);
  mapper::BlockValues values;
  values.fill(mapper::kUnknownLevel);
  values[mapper::encode(at) & mapper::kPlaceMask] = level;
  values[mapper::encode({at.x, at.y, at.z + 1}) & mapper::kPlaceMask] = second_level;
  REQUIRE(map.write_block(mapper::block_of(at), values));
  const ColumnReader reader(ground_layers(map.grid(), {}), voxels_per_ground_cell(map.grid()), 20);
  std::array<Evidence, 64> cells{};
  reader.read(map, map.find(mapper::block_of(at)), at.z / 8, cells);
  const int voxels = voxels_per_ground_cell(map.grid());
  const int x = at.x % 8 / voxels;
  const int y = at.y % 8 / voxels;
  return cells[static_cast<std::size_t>(y * reader.cells_per_block() + x)];
}

}  // namespace

TEST_CASE("Every layer says its own") {
  for (const float r : {0.01F, 0.02F, 0.05F}) {
    CHECK(of_voxel(r, -0.001F, 28) == kFloorSeen);
    CHECK(of_voxel(r, -0.001F, 3) == 0);
    CHECK(of_voxel(r, -0.2F, 3) == kDropSeen);
    CHECK(of_voxel(r, -0.2F, 28) == 0);
    CHECK(of_voxel(r, 0.2F, 3) == kAirSeen);
    CHECK(of_voxel(r, 0.09F, 3) == (kAirSeen | kLowSeen));
    CHECK(of_voxel(r, 0.55F, 3) == 0);
    CHECK(of_voxel(r, 0.55F, 28) == (kHitOnce | kObstacle));
    CHECK(of_voxel(r, 0.2F, 20) == kHitOnce);
    CHECK(of_voxel(r, 0.2F, 20, 20) == (kHitOnce | kObstacle));
    CHECK(of_voxel(r, 0.2F, 20, 3) == (kHitOnce | kAirSeen));
    CHECK(of_voxel(r, 0.8F, 28) == 0);
  }
}

TEST_CASE("A uniform block says what its 512 voxels would say one by one") {
  for (const float r : {0.01F, 0.02F, 0.05F}) {
    const mapper::Grid grid{r};
    const ColumnReader reader(ground_layers(grid, {}), voxels_per_ground_cell(grid), 20);
    for (std::int32_t z = reader.first_block_z(); z <= reader.last_block_z(); ++z) {
      for (const std::uint8_t level : {3, 16, 18, 30}) {
        mapper::VoxelMap uniform(grid, {64, 64, 64});
        mapper::VoxelMap dense(grid, {64, 64, 64});
        mapper::BlockValues values;
        values.fill(level);
        const mapper::BlockKey key = mapper::encode({4096, 4096, z});
        REQUIRE(uniform.write_block(key, values));
        REQUIRE(dense.write_block(key, values));
        if (dense.find(key) == mapper::kNoSlot) continue;
        REQUIRE(dense.header(dense.find(key)).plane == mapper::kNoSlot);
        REQUIRE(dense.make_dense(dense.header(dense.find(key))));
        std::array<Evidence, 64> a{};
        std::array<Evidence, 64> b{};
        reader.read(uniform, uniform.find(key), z, a);
        reader.read(dense, dense.find(key), z, b);
        const std::size_t cells = static_cast<std::size_t>(reader.cells_per_block() * reader.cells_per_block());
        for (std::size_t i = 0; i < cells; ++i) REQUIRE(a[i] == b[i]);
      }
    }
  }
}

TEST_CASE("Blocks one above the other make an obstacle of two single hits, and of floor and drop a floor") {
  CHECK(together(kHitOnce, kAirSeen) == (kHitOnce | kAirSeen));
  CHECK(together(kHitOnce, kHitOnce) == (kHitOnce | kObstacle));
  CHECK(together(kHitOnce | kObstacle, kFloorSeen) == (kHitOnce | kObstacle | kFloorSeen));
  CHECK(settled(together(kFloorSeen, kDropSeen)) == kFloorSeen);
  CHECK(settled(kDropSeen | kAirSeen) == (kDropSeen | kAirSeen));
}
