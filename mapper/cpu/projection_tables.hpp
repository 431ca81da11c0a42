// SPDX-License-Identifier: Apache-2.0
// Where the voxels of a block lie from its first one, as the camera sees them: the same for all blocks of a frame.
#pragma once

#include "mapper/cpu/frame_geometry.hpp"
#include "mapper/cpu/kernels/kernels.hpp"

namespace g3d::mapper::cpu {

void fill_projection_tables(const SensorGeometry& sensor, const FrameGeometry& frame, ProjectionTables& tables);

/// The middle of a brick of 4x4x4 voxels lies half way between its first voxel and its last.
[[nodiscard]] inline float middle_of_brick(const float (&table)[512], std::size_t first_place) {
  return 0.5F * (table[first_place] + table[first_place + 63]);
}

}  // namespace g3d::mapper::cpu
