// SPDX-License-Identifier: Apache-2.0
#include "mapper/map_sampler.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

std::vector<BlockKey> target_keys(const MapSampler& sampler) {
  std::vector<BlockKey> keys;
  sampler.add_target_keys(keys);
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

}  // namespace

TEST_CASE("a map that stands where the grid does is taken block by block, as it is") {
  const auto map = tests::random_map(7, 40);
  MapSampler sampler(*map, {}, map->grid(), {});
  CHECK(target_keys(sampler) == map->sorted_keys());
  BlockValues expected;
  BlockValues found;
  for (const BlockKey key : map->sorted_keys()) {
    map->read_stored_block(key, expected);
    sampler.sample(key, found);
    REQUIRE(found == expected);
  }
  sampler.sample(block_of({8, 8, 8}), found);
  CHECK(std::all_of(found.begin(), found.end(), [](Rgbo v) { return v == kUnknownRgbo; }));
}

TEST_CASE("a map that is turned is looked up at the centre of each voxel, and no block of it is missed", "[slow]") {
  const auto map = tests::furnished_room(0.05F);
  const hal::Pose T_world_map = hal::from_xyz_rpy(0.31, -0.12, 0.07, 0.0, 0.0, 0.4);
  const hal::Pose T_world_target = hal::from_xyz_rpy(-0.2, 0.5, 0.0, 0.0, 0.1, -1.1);
  MapSampler sampler(*map, T_world_map, map->grid(), T_world_target);
  const hal::Pose T_map_target = hal::compose(hal::inverse(T_world_map), T_world_target);
  BlockValues found;
  std::uint64_t known = 0;
  for (const BlockKey key : target_keys(sampler)) {
    sampler.sample(key, found);
    const VoxelIndex origin = block_origin(key);
    for (std::size_t i = 0; i < found.size(); ++i) {
      const VoxelIndex place = decode(i);
      const auto centre = map->grid().centre_m(VoxelIndex{origin.x + place.x, origin.y + place.y, origin.z + place.z});
      const hal::Pose at = hal::compose(T_map_target, {{centre[0], centre[1], centre[2]}, {0, 0, 0, 1}});
      const auto& p = at.translation_m;
      // A centre on the edge of two voxels may fall to either side.
      const auto r = static_cast<double>(map->grid().resolution_m);
      if (std::any_of(p.begin(), p.end(), [&](double x) { return std::abs(x / r - std::round(x / r)) < 1e-6; }))
        continue;
      const VoxelIndex source{static_cast<std::int32_t>(std::ceil(p[0] / r)) + 32767,
                              static_cast<std::int32_t>(std::ceil(p[1] / r)) + 32767,
                              static_cast<std::int32_t>(std::ceil(p[2] / r)) + 32767};
      REQUIRE((found[i] & ~kHasColourBit) == map->at(source));
      known += map->at(source) != kUnknownRgbo ? 1 : 0;
    }
  }
  const MapCounts counts = map->counts();
  CHECK(static_cast<double>(known) == Approx(static_cast<double>(counts.known())).epsilon(0.02));
}
