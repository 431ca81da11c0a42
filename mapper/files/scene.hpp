// SPDX-License-Identifier: Apache-2.0
// What both pictures need to know of a map before they draw it: how far it reaches, where its ceiling is, and which
// occupied voxels have a face that can have been seen.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mapper/files/picture.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

/// The six directions of faces, in the order of the bits of SceneVoxel.
inline constexpr std::array<std::array<int, 3>, 6> kFaceNormals{
    {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};

struct SceneVoxel {
  VoxelIndex index;
  std::uint8_t seen_from = 0;  ///< bit i: the surface that it belongs to can have been seen from kFaceNormals[i]
  std::uint8_t bare = 0;       ///< bit i: no occupied voxel covers the face towards kFaceNormals[i]
  std::uint8_t openness = 0;   ///< how many of the 26 voxels around are not occupied
  Rgb colour;
};

struct Scene {
  std::vector<SceneVoxel> voxels;
  std::array<double, 3> low_m{};  ///< the box that holds all but the outermost 0.2 % of the voxels on each side
  std::array<double, 3> high_m{};
  double ceiling_m = 0;  ///< what lies above is left out: remains of a ceiling
  [[nodiscard]] bool is_above(const std::array<double, 3>& p) const { return p[2] > ceiling_m; }
  [[nodiscard]] bool holds(const std::array<double, 3>& p) const {
    constexpr double kMargin_m = 0.1;
    for (std::size_t i = 0; i < 3; ++i) {
      if (p[i] < low_m[i] - kMargin_m || p[i] > high_m[i] + kMargin_m) return false;
    }
    return !is_above(p);
  }
};

[[nodiscard]] Scene make_scene(const VoxelMap& map, bool use_colour);

/// Blue (low) over green and yellow to red (high), 0..1.
[[nodiscard]] Rgb height_colour(double part);

}  // namespace g3d::mapper
