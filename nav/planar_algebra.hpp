// SPDX-License-Identifier: Apache-2.0
// Poses on the floor, one after the other. Any thread.
#pragma once

#include "hal/geometry.hpp"
#include "hal/twist.hpp"

namespace g3d::nav {

/// T_a_c = T_a_b * T_b_c on the floor.
[[nodiscard]] hal::PlanarPose compose(const hal::PlanarPose& T_a_b, const hal::PlanarPose& T_b_c);
[[nodiscard]] hal::PlanarPose inverse(const hal::PlanarPose& T_a_b);
/// The floor's part of a pose.
[[nodiscard]] hal::PlanarPose on_plane(const hal::Pose& T_world_base);

}  // namespace g3d::nav
