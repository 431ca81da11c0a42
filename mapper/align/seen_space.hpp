// SPDX-License-Identifier: Apache-2.0
// What a map says of the space in which a surface was found. A surface in the middle of space that was seen free has
// come there: somebody who walks, a door. One around which everything is free by now has left. Neither may be aligned
// to. Thread: that of the map.
#pragma once

#include <array>

namespace g3d::mapper {
class VoxelMap;
}

namespace g3d::mapper::align {

class SeenSpace {
 public:
  explicit SeenSpace(const VoxelMap& map) : map_(&map) {}

  /// The voxel of a point (world, m) was seen free.
  [[nodiscard]] bool is_free(const std::array<float, 3>& point_m) const;
  /// The voxel of a point (world, m) and all 26 around it are known to be free: no error of a pose or of a reading
  /// puts a wall there. False outside of the map.
  [[nodiscard]] bool is_clear(const std::array<float, 3>& point_m) const;

 private:
  const VoxelMap* map_;
};

}  // namespace g3d::mapper::align
