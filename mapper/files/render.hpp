// SPDX-License-Identifier: Apache-2.0
// Pictures of a map for people: `map.png`, a perspective view into the rooms like into a doll's house, and a top view.
// Only faces that the sensor can have seen are drawn, those with free space before them; so ceilings and near walls,
// whose outer sides nobody saw, do not block the view. Maps without free space are cut below the ceiling instead.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hal/geometry.hpp"
#include "hal/image/image_size.hpp"
#include "hal/result.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

struct RenderOptions {
  hal::ImageSize size{1280, 960};
  double azimuth_deg = 215.0;             ///< from where the camera looks, counted from x to y
  double elevation_deg = 48.0;            ///< 1..89
  bool use_colour = true;                 ///< false: by height
  std::span<const hal::Pose> trajectory;  ///< camera poses in the map frame, drawn as a line; may be empty
};

/// 3 * width * height bytes R G B. An empty map gives the background alone.
[[nodiscard]] std::vector<std::uint8_t> render_perspective(const VoxelMap& map, const RenderOptions& options = {});
/// Highest surface below the ceiling of each column, free floor light, the unknown grey; x to the right, y up.
[[nodiscard]] std::vector<std::uint8_t> render_top(const VoxelMap& map, const RenderOptions& options = {});

/// As PNG, by temporary file and rename.
[[nodiscard]] hal::Result<void> write_perspective(const VoxelMap& map, const std::string& path,
                                                  const RenderOptions& options = {});
[[nodiscard]] hal::Result<void> write_top(const VoxelMap& map, const std::string& path,
                                          const RenderOptions& options = {});

}  // namespace g3d::mapper
