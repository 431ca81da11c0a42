// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/pose_drift.hpp"

#include <cmath>

#include "hal/sim/seeded_random.hpp"

namespace g3d::hal {
namespace {

/// Small turns about the world's axes; tangents of half angles, so without sine and cosine.
Pose turn_of(double x_rad, double y_rad, double z_rad) {
  return normalised({{0, 0, 0}, {0.5 * x_rad, 0.5 * y_rad, 0.5 * z_rad, 1.0}});
}

}  // namespace

PoseDrift robot_drift(std::uint64_t seed, double times) {
  PoseDrift drift{.seed = seed};
  drift.translation_scale = 1.0 + times * (drift.translation_scale - 1.0);
  drift.heading_bias_rad_per_s *= times;
  drift.heading_walk_rad_per_root_s *= times;
  return drift;
}

PoseDrift hand_held_drift(std::uint64_t seed, double times) {
  PoseDrift drift = robot_drift(seed, times);
  drift.tilt_walk_rad_per_root_s = 0.003 * times;
  drift.shift_walk_m_per_root_s = 0.003 * times;
  return drift;
}

std::vector<StampedPose> drifted(std::span<const StampedPose> poses, const PoseDrift& drift) {
  SeededRandom random(SeededRandom(drift.seed).bits());  // neighbouring seeds would draw the same numbers one later
  const double bias = random.uniform() < 0.5 ? -drift.heading_bias_rad_per_s : drift.heading_bias_rad_per_s;
  const double scale = random.uniform() < 0.5 ? 2.0 - drift.translation_scale : drift.translation_scale;
  std::vector<StampedPose> result;
  result.reserve(poses.size());
  // Odometry's frame against the true one: turned by T_odometry_world, so that steps keep their own errors.
  Pose turned;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i == 0) {
      result.push_back(poses[0]);
      continue;
    }
    const double dt_s = static_cast<double>(poses[i].stamp_ns - poses[i - 1].stamp_ns) / 1e9;
    const double root_s = std::sqrt(dt_s);
    const auto& now = poses[i].T_world_camera;
    const auto& before = poses[i - 1].T_world_camera;
    Pose step;
    for (std::size_t k = 0; k < 3; ++k) {
      step.translation_m[k] = scale * (now.translation_m[k] - before.translation_m[k]);
    }
    const Pose step_seen = compose(turned, {step.translation_m, {0, 0, 0, 1}});
    Pose pose = result.back().T_world_camera;
    for (std::size_t k = 0; k < 3; ++k) {
      pose.translation_m[k] += step_seen.translation_m[k] + drift.shift_walk_m_per_root_s * root_s * random.gaussian();
    }
    const double x_rad = drift.tilt_walk_rad_per_root_s * root_s * random.gaussian();
    const double y_rad = drift.tilt_walk_rad_per_root_s * root_s * random.gaussian();
    const double z_rad = bias * dt_s + drift.heading_walk_rad_per_root_s * root_s * random.gaussian();
    turned = compose(turn_of(x_rad, y_rad, z_rad), turned);
    pose.rotation_xyzw = compose(turned, {{0, 0, 0}, now.rotation_xyzw}).rotation_xyzw;
    result.push_back({poses[i].stamp_ns, pose});
  }
  return result;
}

}  // namespace g3d::hal
