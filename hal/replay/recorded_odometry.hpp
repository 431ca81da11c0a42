// SPDX-License-Identifier: Apache-2.0
// The camera's way out of a base's recorded bytes: the same reader and the same odometry as on the robot, so that a
// recording gives the poses again that the robot had.
#pragma once

#include <vector>

#include "hal/kobuki/odometry.hpp"
#include "hal/kobuki/rejects.hpp"
#include "hal/replay/kobuki_log.hpp"
#include "hal/replay/trajectory_file.hpp"
#include "hal/twist.hpp"

namespace g3d::hal {

struct RecordedOdometry {
  std::vector<StampedPose> poses;  ///< T_world_camera, stamps rising; for RecordedPoses
  PlanarPose T_world_base;         ///< at the end
  double path_m = 0.0;
  double rotation_rad = 0.0;
  kobuki::RejectCounts rejects;
  kobuki::OdometryCounts counts;
};

/// T_world_base of a base on a flat floor as a pose in space.
[[nodiscard]] Pose to_pose(const PlanarPose& T_world_base);

/// One pose for each packet, at the time at which it was sent, as on the robot: see LinkDelay. Of several at one time
/// the last.
[[nodiscard]] RecordedOdometry recompute_odometry(const KobukiLog& log, const Pose& T_base_camera,
                                                  const PlanarPose& start = {});

}  // namespace g3d::hal
