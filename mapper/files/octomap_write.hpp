// SPDX-License-Identifier: Apache-2.0
// A map as an OctoMap file (octomap_format.hpp), straight from its ascending M-codes. Eight equal children (level and
// colour) become one leaf; inner nodes carry the maximum level and the average colour, as OctoMap computes them.
#pragma once

#include <string>

#include "hal/result.hpp"
#include "mapper/files/bytes.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

/// `.ot`: a ColorOcTree if any voxel has a colour, else an OcTree. Levels and colours of all known voxels are kept.
[[nodiscard]] Bytes encode_octomap_full(const VoxelMap& map);
/// `.bt`: free and occupied only.
[[nodiscard]] Bytes encode_octomap_binary(const VoxelMap& map);

/// By temporary file, sync and rename. The path's end chooses: `.bt` binary, else full.
[[nodiscard]] hal::Result<void> write_octomap(const VoxelMap& map, const std::string& path);

}  // namespace g3d::mapper
