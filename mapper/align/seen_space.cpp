// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/seen_space.hpp"

#include "mapper/voxel_map.hpp"

namespace g3d::mapper::align {

bool SeenSpace::is_free(const std::array<float, 3>& point_m) const {
  return state_of(map_->at(map_->grid().to_index(point_m[0], point_m[1], point_m[2]))) == State::free;
}

bool SeenSpace::is_clear(const std::array<float, 3>& point_m) const {
  const VoxelIndex at = map_->grid().to_index(point_m[0], point_m[1], point_m[2]);
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        if (state_of(map_->at(VoxelIndex{at.x + x, at.y + y, at.z + z})) != State::free) return false;
      }
    }
  }
  return true;
}

}  // namespace g3d::mapper::align
