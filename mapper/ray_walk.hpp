// SPDX-License-Identifier: Apache-2.0
// The way of a ray through the map, voxel by voxel (Amanatides and Woo), for questions asked in bulk. Both twins
// compile this source, so it uses float32, + - * / and sqrt alone, and distances to faces are products, not sums: they
// stay exact to a few roundings however long the ray is. cast_ray() in query.hpp is the same walk in double.
#pragma once

#include <cstdint>

#include "mapper/morton.hpp"
#include "mapper/rgbo.hpp"

namespace g3d::mapper {

enum class RayEnd : std::uint8_t { occupied, unknown, max_range, left_grid };

/// One ray of many. Plain data: it goes to a card as it is.
struct BulkRay {
  float origin_m[3];   ///< world frame
  float direction[3];  ///< length 1e-15..1e15; if it is zero or no number, nothing is found
  float max_range_m;
  std::uint32_t stop_at_unknown;  ///< 0 or 1
};
struct BulkHit {
  std::uint16_t voxel[3];  ///< the last one looked at in the grid; zeros if there was none
  RayEnd end;
  std::uint8_t reserved;
  float distance_m;  ///< to where the ray enters its last voxel, or leaves the grid; max_range_m where it found nothing
};

/// Stored bytes of a block's voxels.
struct BlockLevels {
  const std::uint8_t* plane;  ///< nullptr: all have uniform_level
  std::uint32_t uniform_level;
};

/// Distances in voxels times the length of the direction.
struct RayWalk {
  std::int32_t cell[3];
  std::int32_t step[3];
  float first[3];    ///< to the first face that it crosses on each axis; infinite if it crosses none
  float delta[3];    ///< from face to face
  float crossed[3];  ///< faces so far
  float next[3];     ///< first + crossed * delta
  float at;          ///< to where it enters the cell
};

/// What is slower on an axis moves along it by less than a voxel in the whole grid.
inline constexpr float kLeastSpeed = 1e-10F;
inline constexpr float kLargestFloat = 3.402823466e38F;

/// False if the ray does not begin in the grid, or its origin is no number.
[[nodiscard]] constexpr bool begin_walk(RayWalk& w, const float (&origin_m)[3], const float (&direction)[3],
                                        float resolution_m) {
  w.at = 0.0F;
  bool is_inside = true;
  for (int axis = 0; axis < 3; ++axis) {
    const float x = origin_m[axis] / resolution_m;
    const bool fits = x > -32768.0F && x <= 32768.0F;
    is_inside &= fits;
    const float upper = fits ? __builtin_ceilf(x) : 0.0F;
    const float d = direction[axis];
    const bool rises = d > kLeastSpeed;
    const bool moves = rises || d < -kLeastSpeed;
    w.cell[axis] = kAxisOffset_cells + static_cast<std::int32_t>(upper);
    w.step[axis] = rises ? 1 : moves ? -1 : 0;
    w.delta[axis] = moves ? 1.0F / (rises ? d : -d) : 0.0F;
    w.first[axis] = moves ? (rises ? upper - x : x - (upper - 1.0F)) * w.delta[axis] : __builtin_inff();
    w.crossed[axis] = 0.0F;
    w.next[axis] = w.first[axis];
  }
  return is_inside;
}

/// Into the next cell; where faces meet, across that of the lower axis first.
constexpr void take_step(RayWalk& w) {
  const bool x = w.next[0] <= w.next[1] && w.next[0] <= w.next[2];
  const bool y = !x && w.next[1] <= w.next[2];
  const bool taken[3] = {x, y, !x && !y};
  w.at = x ? w.next[0] : y ? w.next[1] : w.next[2];
  for (int axis = 0; axis < 3; ++axis) {
    w.crossed[axis] += taken[axis] ? 1.0F : 0.0F;
    w.cell[axis] += taken[axis] ? w.step[axis] : 0;
    w.next[axis] = w.first[axis] + w.crossed[axis] * w.delta[axis];
  }
}

[[nodiscard]] constexpr bool is_in_grid(const RayWalk& w) { return (w.cell[0] | w.cell[1] | w.cell[2]) >> 16 == 0; }
[[nodiscard]] constexpr BlockKey block_under(const RayWalk& w) {
  return block_of(VoxelIndex{w.cell[0], w.cell[1], w.cell[2]});
}
[[nodiscard]] constexpr std::uint32_t place_under(const RayWalk& w) {
  return place_at(w.cell[0] & 7, w.cell[1] & 7, w.cell[2] & 7);
}

enum class WalkEnd : std::uint8_t { stopped, at_range, left_grid };

/// Walks on while the ray enters cells within `range`. `blocks.find(key)` gives BlockLevels; `stops(walk, state)` is
/// asked in every cell.
template <typename Blocks, typename Stops>
constexpr WalkEnd follow(RayWalk& w, float range, const Blocks& blocks, Stops&& stops) {
  BlockLevels block{};
  std::int32_t looked_up[3] = {-1, -1, -1};  // a cell of the block; no cell of any at first
  while (w.at <= range) {
    if (!is_in_grid(w)) return WalkEnd::left_grid;
    const std::int32_t differs = (w.cell[0] ^ looked_up[0]) | (w.cell[1] ^ looked_up[1]) | (w.cell[2] ^ looked_up[2]);
    if (differs >> 3 != 0) {
      block = blocks.find(block_under(w));
      for (int axis = 0; axis < 3; ++axis) looked_up[axis] = w.cell[axis];
    }
    const std::uint32_t byte = block.plane != nullptr ? block.plane[place_under(w)] : block.uniform_level;
    if (stops(w, state_of_level(static_cast<std::uint8_t>(byte & kLevelMask)))) return WalkEnd::stopped;
    take_step(w);
  }
  return WalkEnd::at_range;
}

template <typename Blocks>
constexpr BulkHit cast_bulk_ray(const BulkRay& ray, float resolution_m, const Blocks& blocks) {
  BulkHit hit{{0, 0, 0}, RayEnd::max_range, 0, ray.max_range_m};
  const float* d = ray.direction;
  const float length = __builtin_sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  const float range = ray.max_range_m / resolution_m;
  if (!(length > 0.0F && length <= kLargestFloat && range >= 0.0F)) return hit;
  const float unit[3] = {d[0] / length, d[1] / length, d[2] / length};
  RayWalk w{};
  if (!begin_walk(w, ray.origin_m, unit, resolution_m)) return {{0, 0, 0}, RayEnd::left_grid, 0, 0.0F};
  State last = State::free;
  const WalkEnd end = follow(w, range, blocks, [&](const RayWalk& at, State state) {
    for (int axis = 0; axis < 3; ++axis) hit.voxel[axis] = static_cast<std::uint16_t>(at.cell[axis]);
    last = state;
    return state == State::occupied || (state == State::unknown && ray.stop_at_unknown != 0);
  });
  if (end == WalkEnd::at_range) return hit;
  hit.end = end == WalkEnd::left_grid ? RayEnd::left_grid
            : last == State::occupied ? RayEnd::occupied
                                      : RayEnd::unknown;
  hit.distance_m = w.at * resolution_m;
  return hit;
}

}  // namespace g3d::mapper
