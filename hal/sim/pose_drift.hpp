// SPDX-License-Identifier: Apache-2.0
// Odometry that drifts, out of poses that do not: what wheels and a gyro (or a hand-held camera's own tracking) would
// have said. The same seed gives the same drift.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hal/replay/trajectory_file.hpp"

namespace g3d::hal {

struct PoseDrift {
  double translation_scale = 1.02;
  double heading_bias_rad_per_s = 0.0052359878;       ///< 0.3 degrees/s; its sign is drawn
  double heading_walk_rad_per_root_s = 0.0087266463;  ///< 0.5 degrees per root second
  double tilt_walk_rad_per_root_s = 0.0;              ///< roll and pitch, for hand-held cameras
  double shift_walk_m_per_root_s = 0.0;               ///< every axis, for hand-held cameras
  std::uint64_t seed = 1;
};
/// As a robot on wheels drifts, and as a hand-held camera does; `times` as much.
[[nodiscard]] PoseDrift robot_drift(std::uint64_t seed, double times = 1.0);
[[nodiscard]] PoseDrift hand_held_drift(std::uint64_t seed, double times = 1.0);

/// The first pose stays. Turns are about the world's axes (z up), translations are scaled step by step.
[[nodiscard]] std::vector<StampedPose> drifted(std::span<const StampedPose> poses, const PoseDrift& drift);

}  // namespace g3d::hal
