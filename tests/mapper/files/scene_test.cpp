// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/scene.hpp"

#include <catch2/catch.hpp>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

/// A block that is occupied in its lower half, with `above` in the upper.
std::unique_ptr<VoxelMap> slab(std::uint8_t above, std::uint8_t gap) {
  auto map = std::make_unique<VoxelMap>(Grid{0.1F}, MapCapacity{64, 64, 64});
  BlockValues values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const int z = decode(i).z;
    values[i] = z < 3 ? 32U : z < 5 ? gap : above;
  }
  REQUIRE(map->write_block(block_of({32768, 32768, 32768}), values));
  return map;
}

}  // namespace

TEST_CASE("A surface is seen from where free space is") {
  const Scene scene = make_scene(*slab(0, 0), true);
  REQUIRE(scene.voxels.size() == 3 * 64 - 6 * 6);  // all but the inner ones of the two lower layers and what they cover
  for (const SceneVoxel& voxel : scene.voxels) {
    REQUIRE(static_cast<int>(voxel.seen_from) == 1 << 4);
    REQUIRE((voxel.bare >> 4 & 1) == (voxel.index.z == 32770 ? 1 : 0));
  }
}

TEST_CASE("A thin unknown seam before a surface is forgiven, a thick one is not") {
  CHECK_FALSE(make_scene(*slab(0, 16), true).voxels.empty());
  auto map = slab(16, 16);
  BlockValues air;
  air.fill(0);
  REQUIRE(map->write_block(block_of({32768, 32768, 32776}), air));
  CHECK(make_scene(*map, true).voxels.empty());
}

TEST_CASE("In fine maps, pits inside of a noisy wall are not taken for rooms") {
  VoxelMap map(Grid{0.0125F}, MapCapacity{64, 64, 64});
  tests::Random random(5);
  BlockValues values;
  for (int y = 0; y < 2; ++y) {
    for (int z = 0; z < 2; ++z) {
      for (Rgbo& value : values) value = random.below(3) == 0 ? 0U : 32U;  // wall: two blocks by two, one thick
      REQUIRE(map.write_block(block_of({32768, 32768 + 8 * y, 32768 + 8 * z}), values));
      values.fill(0);
      REQUIRE(map.write_block(block_of({32776, 32768 + 8 * y, 32768 + 8 * z}), values));  // the room is at higher x
    }
  }
  const Scene scene = make_scene(map, true);
  REQUIRE(scene.voxels.size() > 500);
  for (const SceneVoxel& voxel : scene.voxels) REQUIRE(static_cast<int>(voxel.seen_from) == 1);
}

TEST_CASE("Maps without free space show what borders on the unknown, cut below the ceiling") {
  const auto room = tests::furnished_room(0.1F, false);
  const Scene scene = make_scene(*room, true);
  CHECK(scene.voxels.size() == room->counts().occupied);
  CHECK(scene.ceiling_m > 1.2);
  CHECK(scene.ceiling_m < 2.3);
}

TEST_CASE("The scene's box holds the room and not what strays") {
  const auto room = tests::furnished_room(0.1F);
  BlockValues values;
  values.fill(kUnknownRgbo);
  values[0] = 32;
  values[1] = 0;
  REQUIRE(room->write_block(block_of({40000, 40000, 40000}), values));
  const Scene scene = make_scene(*room, true);
  CHECK(scene.low_m[0] == Approx(-3.05).margin(0.2));
  CHECK(scene.high_m[0] == Approx(3.05).margin(0.2));
  CHECK(scene.high_m[2] == Approx(2.5).margin(0.2));
}

TEST_CASE("Colours are the voxels' own, or their height's") {
  const auto room = tests::furnished_room(0.1F);
  const Scene own = make_scene(*room, true);
  const Scene by_height = make_scene(*room, false);
  REQUIRE(own.voxels.size() == by_height.voxels.size());
  for (std::size_t i = 0; i < own.voxels.size(); i += 37) {
    const Rgbo value = room->at(own.voxels[i].index);
    REQUIRE(own.voxels[i].colour.r == Approx(static_cast<float>(value >> 24) / 255.0F));
    REQUIRE(own.voxels[i].colour.b == Approx(static_cast<float>((value >> 8) & 0xFF) / 255.0F));
  }
  CHECK(by_height.voxels.front().colour.b > by_height.voxels.front().colour.r);  // the floor is blue
  CHECK(height_colour(0).b > height_colour(0).r);
  CHECK(height_colour(1).r > height_colour(1).b);
  CHECK(height_colour(-5).r == height_colour(0).r);
}

TEST_CASE("An empty map is an empty scene") {
  const VoxelMap map(Grid{0.1F}, {8, 8, 8});
  CHECK(make_scene(map, true).voxels.empty());
}
