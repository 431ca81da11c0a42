// SPDX-License-Identifier: Apache-2.0
// What a camera would newly see from a pose: the unknown voxels that its rays pass before they meet something occupied,
// each counted once however many rays pass it. A ray that meets something nearer than the camera can measure shows
// nothing. Source of both twins, as ray_walk.hpp is.
#pragma once

#include <cstdint>

#include "mapper/ray_walk.hpp"

namespace g3d::mapper {

struct LookGain {
  std::uint32_t unknown_voxels;  ///< distinct ones
  std::uint32_t blocked_rays;    ///< met something that the camera can measure
  std::uint32_t near_rays;       ///< met something nearer
  std::uint32_t reserved;
};

/// One look of many. Plain data: it goes to a card as it is, and comes back with its gain.
struct Look {
  float rotation[9];       ///< R of T_world_camera, row-major
  float position_m[3];     ///< t of T_world_camera
  std::int32_t first[3];   ///< the box of blocks around all rays, in blocks; see cpu::FrameGeometry
  std::int32_t blocks[3];  ///< of the box along each axis; 0: out of the grid, nothing is seen
  LookGain gain;
};

/// What all looks of a camera share.
struct LookModel {
  float resolution_m;
  float near_m;  ///< depth
  float far_m;
  std::int32_t width_px;
  std::int32_t height_px;
  std::int32_t stride_px;  ///< one ray for so many columns and rows
};

inline constexpr std::uint32_t kSeenWords = kBlockVoxels / 32;  ///< one bit per voxel of a block

/// Where the bit of a voxel is among those of the look's box: 32 * word + bit; ~0 if it is not in the box.
[[nodiscard]] constexpr std::uint64_t seen_bit(const Look& look, const RayWalk& w) {
  const std::int32_t x = (w.cell[0] >> 3) - look.first[0];
  const std::int32_t y = (w.cell[1] >> 3) - look.first[1];
  const std::int32_t z = (w.cell[2] >> 3) - look.first[2];
  const bool inside = x >= 0 && y >= 0 && z >= 0 && x < look.blocks[0] && y < look.blocks[1] && z < look.blocks[2];
  const std::int32_t block = x + look.blocks[0] * (y + look.blocks[1] * z);
  return inside ? static_cast<std::uint64_t>(block) * kBlockVoxels + place_under(w) : ~std::uint64_t{0};
}

enum class LookEnd : std::uint8_t { open, blocked, near };

/// Follows the ray of a pixel and calls `mark(bit)` for every unknown voxel that it shows. Distances are depths.
template <typename Blocks, typename Mark>
constexpr LookEnd look_along(const LookModel& model, const Look& look, float column_slope, float row_slope,
                             const Blocks& blocks, Mark&& mark) {
  const float* R = look.rotation;
  const float direction[3] = {R[0] * column_slope + R[1] * row_slope + R[2],
                              R[3] * column_slope + R[4] * row_slope + R[5],
                              R[6] * column_slope + R[7] * row_slope + R[8]};
  RayWalk w{};
  if (!begin_walk(w, look.position_m, direction, model.resolution_m)) return LookEnd::open;
  const auto is_occupied = [](const RayWalk&, State state) { return state == State::occupied; };
  if (follow(w, model.near_m / model.resolution_m, blocks, is_occupied) == WalkEnd::stopped) return LookEnd::near;
  (void)begin_walk(w, look.position_m, direction, model.resolution_m);
  const WalkEnd end = follow(w, model.far_m / model.resolution_m, blocks, [&](const RayWalk& at, State state) {
    if (state == State::unknown) {
      const std::uint64_t bit = seen_bit(look, at);
      if (bit != ~std::uint64_t{0}) mark(bit);
    }
    return state == State::occupied;
  });
  return end == WalkEnd::stopped ? LookEnd::blocked : LookEnd::open;
}

}  // namespace g3d::mapper
