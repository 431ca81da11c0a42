// SPDX-License-Identifier: Apache-2.0
// The ray ends of one frame as plain world points: what another mapper must be given to be compared with ours.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hal/messages.hpp"

namespace g3d::test {

struct RayList {
  std::array<float, 3> origin_m;
  std::vector<std::array<float, 3>> hits_m;  ///< readings within the certainty bounds
  std::vector<std::array<float, 3>> far_m;   ///< where the rays of farther readings are cut off
};

/// Readings without a value or nearer than near_m are left out.
[[nodiscard]] RayList ray_list(const hal::CameraModel& camera, const std::uint16_t* depth,
                               const hal::Pose& T_world_camera, float near_m = 0.8F, float far_m = 3.5F);

}  // namespace g3d::test
