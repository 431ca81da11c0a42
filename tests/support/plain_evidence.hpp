// SPDX-License-Identifier: Apache-2.0
// What one frame says about the world, pixel by pixel and voxel by voxel: where rays end, what is hit, what is seen
// through. The slow half of the plain mapper.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <unordered_map>
#include <vector>

#include "mapper/cpu/frame_geometry.hpp"
#include "mapper/mapper.hpp"

namespace g3d::test {

/// For every pixel the raw depth up to which its ray carves, straight from the comment in ray_ends.hpp.
[[nodiscard]] std::vector<std::uint16_t> plain_ray_ends(const mapper::cpu::SensorGeometry& sensor,
                                                        const std::uint16_t* depth, std::span<const std::uint16_t> mask,
                                                        bool carve_invalid);
/// May this pixel give its colour? Its four neighbours lie on the same surface.
[[nodiscard]] bool plain_gives_colour(const hal::CameraModel& camera, const std::uint16_t* depth, int u, int v);

struct PlainHit {
  bool has_colour = false;
  std::uint32_t pixel = 0;  ///< valid if has_colour
};
using PlainHits = std::map<mapper::MCode, PlainHit>;
[[nodiscard]] PlainHits plain_hits(const mapper::cpu::SensorGeometry& sensor, const mapper::cpu::FrameGeometry& frame,
                                   const std::uint16_t* depth);

/// Voxels with a reading that is too near to be trusted: no ray frees them.
[[nodiscard]] std::set<mapper::MCode> plain_held(const mapper::cpu::SensorGeometry& sensor,
                                                 const mapper::cpu::FrameGeometry& frame, const std::uint16_t* depth);

/// The voxels that a ray passes before it reaches its last, in order. `end_raw`: depth of the end in raw units.
[[nodiscard]] std::vector<mapper::VoxelIndex> plain_ray(const mapper::cpu::SensorGeometry& sensor,
                                                        const mapper::cpu::FrameGeometry& frame, int u, int v,
                                                        std::uint16_t end_raw, mapper::IntegratorKind kind);

/// By which rays a voxel was seen through.
enum class Seen : std::uint8_t { no, weak, strong };
using PlainFree = std::unordered_map<mapper::MCode, Seen>;
[[nodiscard]] PlainFree plain_free(const mapper::cpu::SensorGeometry& sensor, const mapper::cpu::FrameGeometry& frame,
                                   const std::uint16_t* depth, const std::vector<std::uint16_t>& ends,
                                   mapper::IntegratorKind kind);

}  // namespace g3d::test
