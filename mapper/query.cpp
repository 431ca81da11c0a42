// SPDX-License-Identifier: Apache-2.0
#include "mapper/query.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace g3d::mapper {
namespace {

constexpr int kLevelsInBlock = 3;

NodeState to_node_state(State state) {
  switch (state) {
    case State::free:
      return NodeState::free;
    case State::occupied:
      return NodeState::occupied;
    case State::unknown:
      break;
  }
  return NodeState::unknown;
}

/// Joins states of parts: different ones are mixed.
class Joined {
 public:
  void add(NodeState part) {
    state_ = empty_ || state_ == part ? part : NodeState::mixed;
    empty_ = false;
  }
  [[nodiscard]] bool is_mixed() const { return !empty_ && state_ == NodeState::mixed; }
  [[nodiscard]] NodeState state() const { return state_; }

 private:
  bool empty_ = true;
  NodeState state_ = NodeState::unknown;
};

/// State of `count` places of one block, from `first` on.
NodeState part_state(const VoxelMap& map, std::uint32_t slot, std::size_t first, std::size_t count) {
  if (slot == kNoSlot) return NodeState::unknown;
  const BlockHeader& header = map.header(slot);
  if (header.plane == kNoSlot) return to_node_state(state_of_level(header.uniform_level));
  const LevelPlane& levels = map.plane(header.plane);
  Joined joined;
  for (std::size_t i = first; i < first + count && !joined.is_mixed(); ++i) {
    joined.add(to_node_state(state_of_level(levels[i] & kLevelMask)));
  }
  return joined.state();
}

/// 32767 + ceil(x / r); -1 outside of the grid or for NaN.
std::int32_t cell_index(double x_m, double resolution_m) {
  const double k = kAxisOffset_cells + std::ceil(x_m / resolution_m);
  return k >= 0 && k < kAxisCells ? static_cast<std::int32_t>(k) : -1;
}

}  // namespace

const char* to_string(NodeState state) {
  switch (state) {
    case NodeState::unknown:
      return "unknown";
    case NodeState::free:
      return "free";
    case NodeState::occupied:
      return "occupied";
    case NodeState::mixed:
      return "mixed";
  }
  return "?";
}

State state_at(const VoxelMap& map, const std::array<double, 3>& point_m) {
  const auto r = static_cast<double>(map.grid().resolution_m);
  return state_of(map.at(VoxelIndex{cell_index(point_m[0], r), cell_index(point_m[1], r), cell_index(point_m[2], r)}));
}

NodeState node_state(const VoxelMap& map, MCode code, int levels_up) {
  if (levels_up <= kLevelsInBlock) {
    const std::size_t count = std::size_t{1} << (3 * levels_up);
    return part_state(map, map.find(code >> kBlockShift), (code & kPlaceMask) & ~(count - 1), count);
  }
  const int shift = 3 * (levels_up - kLevelsInBlock);
  const std::uint64_t blocks = std::uint64_t{1} << shift;
  const BlockKey first = (code >> kBlockShift) >> shift << shift;
  Joined joined;
  if (blocks <= map.slot_end()) {
    for (std::uint64_t i = 0; i < blocks && !joined.is_mixed(); ++i)
      joined.add(part_state(map, map.find(first + i), 0, kBlockVoxels));
    return joined.state();
  }
  // More blocks than the map has: some are missing, so look at those that are there.
  joined.add(NodeState::unknown);
  for (std::uint32_t slot = 0; slot < map.slot_end() && !joined.is_mixed(); ++slot) {
    const BlockKey key = map.header(slot).key;
    if (key != VoxelMap::kNoKey && key >> shift == first >> shift) joined.add(part_state(map, slot, 0, kBlockVoxels));
  }
  return joined.state();
}

RayHit cast_ray(const VoxelMap& map, const std::array<double, 3>& origin_m, const std::array<double, 3>& direction,
                const RayOptions& options) {
  const auto r = static_cast<double>(map.grid().resolution_m);
  const double length =
      std::sqrt(direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]);
  RayHit hit{RayEnd::max_range, {}, options.max_range_m};
  if (!(length > 0) || !std::isfinite(length)) return hit;
  std::array<std::int32_t, 3> cell;
  std::array<std::int32_t, 3> step;
  std::array<double, 3> next_m;   // distance to the next face on each axis
  std::array<double, 3> delta_m;  // and from face to face
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cell[axis] = cell_index(origin_m[axis], r);
    const double d = direction[axis] / length;
    step[axis] = d > 0 ? 1 : d < 0 ? -1 : 0;
    delta_m[axis] = d != 0 ? r / std::abs(d) : std::numeric_limits<double>::infinity();
    const double face_m = (cell[axis] + (d > 0 ? 0.0 : -1.0) - kAxisOffset_cells) * r;
    next_m[axis] = d != 0 ? (face_m - origin_m[axis]) / d : std::numeric_limits<double>::infinity();
  }
  double distance_m = 0;
  while (distance_m <= options.max_range_m) {
    hit.voxel = {cell[0], cell[1], cell[2]};
    if (!is_inside_grid(hit.voxel)) return {RayEnd::left_grid, hit.voxel, distance_m};
    const State state = state_of(map.at(hit.voxel));
    if (state == State::occupied) return {RayEnd::occupied, hit.voxel, distance_m};
    if (state == State::unknown && options.stop_at_unknown) return {RayEnd::unknown, hit.voxel, distance_m};
    const auto axis = static_cast<std::size_t>(std::min_element(next_m.begin(), next_m.end()) - next_m.begin());
    distance_m = next_m[axis];
    next_m[axis] += delta_m[axis];
    cell[axis] += step[axis];
  }
  return hit;
}

VoxelBox voxels_in(const Grid& grid, const Box& box) {
  const auto r = static_cast<double>(grid.resolution_m);
  std::array<std::int32_t, 3> low;
  std::array<std::int32_t, 3> high;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(box.low_m[axis] <= box.high_m[axis])) return {};
    // centre (k - 32767.5) r >= low  <=>  k >= low / r + 32767.5
    low[axis] = static_cast<std::int32_t>(std::clamp(std::ceil(box.low_m[axis] / r + 32767.5), 0.0, 65536.0));
    high[axis] = static_cast<std::int32_t>(std::clamp(std::floor(box.high_m[axis] / r + 32767.5), -1.0, 65535.0));
  }
  return {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
}

std::vector<BlockKey> blocks_in(const VoxelMap& map, const VoxelBox& box) {
  std::vector<BlockKey> keys;
  if (box.low.x > box.high.x || box.low.y > box.high.y || box.low.z > box.high.z) return keys;
  const auto blocks_along = [](std::int32_t low, std::int32_t high) {
    return static_cast<std::uint64_t>((high >> 3) - (low >> 3)) + 1;
  };
  const std::uint64_t in_box =
      blocks_along(box.low.x, box.high.x) * blocks_along(box.low.y, box.high.y) * blocks_along(box.low.z, box.high.z);
  if (in_box <= map.slot_end()) {
    for (std::int32_t z = box.low.z & ~7; z <= box.high.z; z += kBlockSide_cells) {
      for (std::int32_t y = box.low.y & ~7; y <= box.high.y; y += kBlockSide_cells) {
        for (std::int32_t x = box.low.x & ~7; x <= box.high.x; x += kBlockSide_cells) {
          if (map.find(block_of({x, y, z})) != kNoSlot) keys.push_back(block_of({x, y, z}));
        }
      }
    }
  } else {
    for (std::uint32_t slot = 0; slot < map.slot_end(); ++slot) {
      const BlockKey key = map.header(slot).key;
      if (key == VoxelMap::kNoKey) continue;
      const VoxelIndex o = block_origin(key);
      const bool overlaps = o.x <= box.high.x && o.x + 7 >= box.low.x && o.y <= box.high.y && o.y + 7 >= box.low.y &&
                            o.z <= box.high.z && o.z + 7 >= box.low.z;
      if (overlaps) keys.push_back(key);
    }
  }
  std::sort(keys.begin(), keys.end());
  return keys;
}

BoxCounts counts_in(const VoxelMap& map, const VoxelBox& box) {
  BoxCounts counts;
  if (box.low.x > box.high.x || box.low.y > box.high.y || box.low.z > box.high.z) return counts;
  for_each_known_in(map, box, [&](const VoxelIndex&, Rgbo value) {
    ++(state_of(value) == State::occupied ? counts.occupied : counts.free);
  });
  const auto along = [](std::int32_t low, std::int32_t high) { return static_cast<std::uint64_t>(high - low) + 1; };
  const std::uint64_t all = along(box.low.x, box.high.x) * along(box.low.y, box.high.y) * along(box.low.z, box.high.z);
  counts.unknown = all - counts.occupied - counts.free;
  return counts;
}

}  // namespace g3d::mapper
