// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/map_surfaces.hpp"

#include <catch2/catch.hpp>
#include <vector>

using namespace g3d::mapper;
using namespace g3d::mapper::align;

namespace {

void set(VoxelMap& map, const VoxelIndex& v, std::uint8_t level) {
  BlockValues values;
  const BlockKey key = block_of(v);
  map.read_stored_block(key, values);
  values[encode(v) & 511U] = level;
  REQUIRE(map.write_block(key, values));
}

/// A wall of two voxels, x = 0 and 1 beyond the middle of the grid, free before it and unknown behind.
void build_wall(VoxelMap& map) {
  constexpr int kMiddle = 32768;
  for (int y = 0; y < 40; ++y) {
    for (int z = 0; z < 40; ++z) {
      for (int x = -6; x < 0; ++x) set(map, {kMiddle + x, kMiddle + y, kMiddle + z}, 4);
      for (int x = 0; x < 2; ++x) set(map, {kMiddle + x, kMiddle + y, kMiddle + z}, 30);
    }
  }
}

}  // namespace

TEST_CASE("a wall's surface is its first layer, facing where it is free", "[mapper][align]") {
  VoxelMap map(Grid{0.05F}, {512, 512, 64});
  build_wall(map);
  const MapSurfaces surfaces(map);
  REQUIRE(surfaces.samples().size() > 100);
  for (const DepthSample& sample : surfaces.samples()) {
    CHECK(sample.point_m[0] == Approx(0.025F).margin(0.002));
    CHECK(sample.normal[0] < -0.8F);
  }
  CHECK(surfaces.low_m()[1] < 0.2F);
  CHECK(surfaces.high_m()[1] > 1.8F);
  CHECK(surfaces.centre_m()[2] == Approx(1.0F).margin(0.1));
  CHECK(surfaces.coarse().find({0.1F, 1.0F, 1.0F}, {-1, 0, 0}));
}

TEST_CASE("surfaces that are known better than the voxels say are taken as they are", "[mapper][align]") {
  VoxelMap map(Grid{0.1F}, {8, 8, 8});
  std::vector<DepthSample> wall;
  for (int i = 0; i < 400; ++i) {
    wall.push_back(
        {{0.512F, 0.02F * static_cast<float>(i % 20), 0.02F * static_cast<float>(i / 20)}, {-1, 0, 0}, 1.0F});
  }
  const MapSurfaces surfaces(map, wall);
  REQUIRE(surfaces.samples().size() > 10);
  for (const DepthSample& sample : surfaces.samples()) CHECK(sample.point_m[0] == Approx(0.512F).margin(0.001));
  CHECK(surfaces.tolerance_m() < MapSurfaces(map).tolerance_m());
  CHECK(surfaces.low_m()[0] == Approx(0.512F).margin(0.001));
}

TEST_CASE("a map without free space, or without anything, has no surface", "[mapper][align]") {
  VoxelMap map(Grid{0.05F}, {512, 512, 64});
  CHECK(MapSurfaces(map).samples().empty());
  for (int y = 0; y < 40; ++y) set(map, {32768, 32768 + y, 32768}, 30);
  CHECK(MapSurfaces(map).samples().empty());
}

TEST_CASE("samples are thinned evenly, as far as the limit asks", "[mapper][align]") {
  std::vector<DepthSample> samples;
  for (int i = 0; i < 1000; ++i) samples.push_back({{0.01F * static_cast<float>(i), 0, 0}, {0, 0, 1}, 1.0F});
  CHECK(evenly(samples, 0.1F, 1000).size() == Approx(100).margin(2));
  const auto few = evenly(samples, 0.1F, 20);
  CHECK(few.size() <= 20);
  CHECK(few.size() >= 12);
  CHECK(evenly({}, 0.1F, 20).empty());
}
