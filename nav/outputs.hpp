// SPDX-License-Identifier: Apache-2.0
// What a finished map is written as: all files of `--out DIR`, or one file in the format that its ending names.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "hal/geometry.hpp"
#include "hal/result.hpp"
#include "mapper/block_source.hpp"
#include "mapper/files/map_header.hpp"
#include "mapper/summary.hpp"
#include "mapper/voxel_map.hpp"
#include "nav/ground_grid.hpp"
#include "nav/patient_writer.hpp"

namespace g3d::nav {

struct OutputOptions {
  mapper::MapFileMeta meta;               ///< goes into the native file
  HeightBand band;                        ///< of the ground map
  std::span<const hal::Pose> trajectory;  ///< drawn into the pictures; may be empty
};

/// .g3d .ot .bt .ply .pcd .yaml (with its .pgm) .png (top.png: seen from above); anything else is refused
/// (unsupported).
[[nodiscard]] hal::Result<mapper::WrittenFile> write_as(const mapper::VoxelMap& map, const OutputOptions& options,
                                                        const std::string& path);

/// map.g3d first, then map.ot, map.bt, map.ply, ground.pgm + ground.yaml, map.png, top.png. All that is named here
/// outlives the jobs.
[[nodiscard]] std::vector<OutputJob> output_jobs(const mapper::VoxelMap& map, const OutputOptions& options,
                                                 const std::string& folder);
/// All of these, tried once: one that fails does not stop the rest.
[[nodiscard]] Outputs write_outputs(const mapper::VoxelMap& map, const OutputOptions& options,
                                    const std::string& folder);

/// Only map.g3d, of a map that is too large for memory: the other formats need it in memory as a whole.
[[nodiscard]] Outputs write_native_output(const mapper::BlockSource& whole, const OutputOptions& options,
                                          const std::string& folder);

}  // namespace g3d::nav
