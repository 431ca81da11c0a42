// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/recorded_odometry.hpp"

#include "hal/kobuki/link_delay.hpp"
#include "hal/kobuki/packet_reader.hpp"

namespace g3d::hal {

Pose to_pose(const PlanarPose& T_world_base) {
  return from_xyz_rpy(T_world_base.x_m, T_world_base.y_m, 0.0, 0.0, 0.0, T_world_base.heading_rad);
}

RecordedOdometry recompute_odometry(const KobukiLog& log, const Pose& T_base_camera, const PlanarPose& start) {
  RecordedOdometry result;
  kobuki::PacketReader reader;
  kobuki::Odometry odometry(start);
  kobuki::LinkDelay link_delay;
  for (KobukiLog::Cursor records = log.records(); const std::optional<LineRecord> record = records.peek();
       records.advance()) {
    reader.feed(record->bytes, record->t_ns, [&](const kobuki::Feedback& feedback) {
      odometry.update(feedback);
      const StampedPose pose{feedback.received_ns - link_delay.update(feedback),
                             compose(to_pose(odometry.T_world_base()), T_base_camera)};
      if (!result.poses.empty() && result.poses.back().stamp_ns == pose.stamp_ns) result.poses.pop_back();
      if (result.poses.empty() || result.poses.back().stamp_ns < pose.stamp_ns) result.poses.push_back(pose);
    });
  }
  result.T_world_base = odometry.T_world_base();
  result.path_m = odometry.path_m();
  result.rotation_rad = odometry.rotation_rad();
  result.rejects = reader.rejects();
  result.counts = odometry.counts();
  return result;
}

}  // namespace g3d::hal
