// SPDX-License-Identifier: Apache-2.0
// Questions to a map: the state at a point, of a whole octree node, along a ray, in a box.
// Thread: while nobody writes the map.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mapper/ray_walk.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

enum class NodeState : std::uint8_t { unknown, free, occupied, mixed };
[[nodiscard]] const char* to_string(NodeState state);

/// Unknown outside of the grid and for coordinates that are no numbers.
[[nodiscard]] State state_at(const VoxelMap& map, const std::array<double, 3>& point_m);

/// State of the ancestor `levels_up` (0..16) above a voxel, that is of all voxels with the same `M >> 3 levels_up`.
[[nodiscard]] NodeState node_state(const VoxelMap& map, MCode code, int levels_up);

struct RayHit {
  RayEnd end = RayEnd::max_range;
  VoxelIndex voxel;       ///< the last one looked at
  double distance_m = 0;  ///< to where the ray enters it; max_range_m where it found nothing
};
struct RayOptions {
  double max_range_m = 10.0;
  bool stop_at_unknown = false;
};
/// Walks every voxel that the ray passes through (Amanatides and Woo), the one it starts in first. For many rays at
/// once see Mapper::cast_rays().
/// `direction` need not be of unit length; if it is zero or no number, nothing is found.
[[nodiscard]] RayHit cast_ray(const VoxelMap& map, const std::array<double, 3>& origin_m,
                              const std::array<double, 3>& direction, const RayOptions& options = {});

struct Box {
  std::array<double, 3> low_m;
  std::array<double, 3> high_m;
};
/// Voxels, both ends included; empty if low > high on any axis.
struct VoxelBox {
  VoxelIndex low{0, 0, 0};
  VoxelIndex high{-1, -1, -1};
  [[nodiscard]] bool contains(const VoxelIndex& v) const {
    return v.x >= low.x && v.x <= high.x && v.y >= low.y && v.y <= high.y && v.z >= low.z && v.z <= high.z;
  }
};
/// The voxels whose centres lie in the box, cut to the grid.
[[nodiscard]] VoxelBox voxels_in(const Grid& grid, const Box& box);
/// Keys of the blocks in the map that share a voxel with the box, ascending.
[[nodiscard]] std::vector<BlockKey> blocks_in(const VoxelMap& map, const VoxelBox& box);

/// Calls `visit(const VoxelIndex&, Rgbo)` for every known voxel of the box in ascending order of M-code.
template <typename Visit>
void for_each_known_in(const VoxelMap& map, const VoxelBox& box, Visit visit) {
  BlockValues values;
  for (const BlockKey key : blocks_in(map, box)) {
    map.read_block(key, values);
    const VoxelIndex origin = block_origin(key);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (state_of(values[i]) == State::unknown) continue;
      const VoxelIndex place = decode(i);
      const VoxelIndex v{origin.x + place.x, origin.y + place.y, origin.z + place.z};
      if (box.contains(v)) visit(v, values[i]);
    }
  }
}

struct BoxCounts {
  std::uint64_t occupied = 0;
  std::uint64_t free = 0;
  std::uint64_t unknown = 0;
};
[[nodiscard]] BoxCounts counts_in(const VoxelMap& map, const VoxelBox& box);

}  // namespace g3d::mapper
