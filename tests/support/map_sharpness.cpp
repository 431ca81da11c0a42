// SPDX-License-Identifier: Apache-2.0
#include "tests/support/map_sharpness.hpp"

#include "mapper/rgbo.hpp"

namespace g3d::test {
namespace {

bool has_near(const mapper::VoxelMap& map, const mapper::VoxelIndex& v) {
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (mapper::state_of(map.at(mapper::VoxelIndex{v.x + dx, v.y + dy, v.z + dz})) == mapper::State::occupied) {
          return true;
        }
      }
    }
  }
  return false;
}

}  // namespace

double share_near(const mapper::VoxelMap& map, const mapper::VoxelMap& other) {
  std::uint64_t occupied = 0;
  std::uint64_t near = 0;
  mapper::BlockValues values;
  for (const mapper::BlockKey key : map.sorted_keys()) {
    map.read_block(key, values);
    const mapper::VoxelIndex origin = mapper::block_origin(key);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (mapper::state_of(values[i]) != mapper::State::occupied) continue;
      const mapper::VoxelIndex place = mapper::decode(i);
      ++occupied;
      near += has_near(other, {origin.x + place.x, origin.y + place.y, origin.z + place.z}) ? 1 : 0;
    }
  }
  return occupied == 0 ? 1.0 : static_cast<double>(near) / static_cast<double>(occupied);
}

}  // namespace g3d::test
