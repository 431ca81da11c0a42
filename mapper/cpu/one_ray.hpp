// SPDX-License-Identifier: Apache-2.0
// Single rays of the exact walk (kernels/ray_walk.cpp): how far rounding may carry one from its line, and the walk
// itself where a voxel and a ray are too close to a tie for any shorter reasoning. The same float32 operations in the
// same order, so that they round alike.
#pragma once

#include <cstdint>

#include "mapper/cpu/frame_geometry.hpp"
#include "mapper/cpu/kernels/kernels.hpp"
#include "mapper/cpu/ray_ends.hpp"

namespace g3d::mapper::cpu {

/// How far a walk may stray from the line through the pixel's centre, in voxels, up to `reach_cells` from the camera
/// along any axis, if no coordinate of the camera exceeds `coordinate_cells`. A walk of k steps along an axis adds up k
/// parameters of at most k / distance; the additions round by 2^-24 of half their sum each (k^2 / 2), the parameters
/// and the direction by a few times 2^-24 (k), both ends as coordinates do. The factor is twice 2^-24.
[[nodiscard]] inline float walk_error_cells(float reach_cells, float coordinate_cells) {
  return 1.2e-7F * (reach_cells * (0.5F * reach_cells + 20.0F) + 4.0F * coordinate_cells + 16.0F);
}
/// The same for any voxel of a frame's box.
[[nodiscard]] float walk_error_cells(const SensorGeometry& sensor, const FrameGeometry& frame);

/// `column_slope`: the sensor's, padded by kRayLanes. Points into all arguments.
[[nodiscard]] RaySearch ray_search(const SensorGeometry& sensor, const FrameGeometry& frame, const RayEnds& ends,
                                   const float* column_slope);

/// Does the walk of pixel (u, v)'s ray mark `voxel` (x, y, z)? `end_raw`: where the ray ends, 0 = there is none.
[[nodiscard]] bool walk_passes(const RaySearch& search, int u, int v, std::uint16_t end_raw, const std::int32_t* voxel);

/// The same for any pixel of the image, for a voxel that touches the camera: where the camera lies on the border of
/// voxels, all rays are ties. Bundles of neighbouring rays are settled together. `strong`: measured pixels alone.
[[nodiscard]] bool any_walk_passes(const RaySearch& search, const std::int32_t* voxel, bool strong);

}  // namespace g3d::mapper::cpu
