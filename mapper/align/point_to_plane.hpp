// SPDX-License-Identifier: Apache-2.0
// One frame's samples against the surfaces: the sums of one Gauss-Newton step of point-to-plane alignment (Chen and
// Medioni 1992) with a Geman-McClure kernel, and that step.
#pragma once

#include <span>

#include "hal/geometry.hpp"
#include "mapper/align/depth_samples.hpp"
#include "mapper/align/pose_fit.hpp"
#include "mapper/align/surface_map.hpp"

namespace g3d::mapper::align {

/// Residual: how far in front of the surface a sample lies, metres. A sample without a surface, or with one that faces
/// elsewhere, adds nothing.
[[nodiscard]] NormalSums match(std::span<const DepthSample> samples, const SurfaceMap& surfaces,
                               const hal::Pose& T_world_camera, float kernel_m,
                               hal::TimeNs born_by_ns = SurfaceMap::kAnyTime);

/// Gauss-Newton from the predicted pose until nothing moves any more.
[[nodiscard]] FitAnswer fit(std::span<const DepthSample> samples, const SurfaceMap& surfaces,
                            const FitQuestion& question);

}  // namespace g3d::mapper::align
