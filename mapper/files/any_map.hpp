// SPDX-License-Identifier: Apache-2.0
// A map from a file of any kind that we read; the ending chooses: .g3d native, .ot and .bt OctoMap.
#pragma once

#include <memory>
#include <string>

#include "hal/result.hpp"
#include "mapper/files/map_header.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

struct AnyMap {
  std::unique_ptr<VoxelMap> map;
  MapFileMeta meta;    ///< defaults for OctoMap files, which carry none
  std::string format;  ///< "g3d 1", "OctoMap ColorOcTree" ...
  std::uint64_t file_bytes = 0;
};

/// Errors name the file and the remedy.
[[nodiscard]] hal::Result<AnyMap> read_any_map(const std::string& path);

}  // namespace g3d::mapper
