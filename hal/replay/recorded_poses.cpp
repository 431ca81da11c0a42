// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/recorded_poses.hpp"

#include <algorithm>

#include "hal/replay/tum_folder.hpp"

namespace g3d::hal {

Result<std::unique_ptr<RecordedPoses>> RecordedPoses::open(const std::string& folder, const std::string& poses_file) {
  std::string path = poses_file;
  if (path.empty()) {
    Result<std::string> found = find_trajectory(folder);
    if (!found) return found.error();
    path = std::move(found).value();
  }
  Result<std::vector<StampedPose>> poses = read_trajectory(path);
  if (!poses) return poses.error();
  return std::make_unique<RecordedPoses>(std::move(poses).value());
}

std::optional<Pose> RecordedPoses::first() const {
  for (const StampedPose& pose : poses_) {
    if (is_valid(pose.T_world_camera)) return normalised(pose.T_world_camera);
  }
  return std::nullopt;
}

PoseStatus RecordedPoses::pose_at(TimeNs stamp_ns, Pose& T_world_camera) const {
  const auto after = std::lower_bound(poses_.begin(), poses_.end(), stamp_ns,
                                      [](const StampedPose& pose, TimeNs stamp) { return pose.stamp_ns < stamp; });
  if (after == poses_.end()) return PoseStatus::not_known;
  if (after->stamp_ns == stamp_ns) {
    if (!is_valid(after->T_world_camera)) return PoseStatus::invalid;
    T_world_camera = normalised(after->T_world_camera);
    return PoseStatus::ok;
  }
  if (after == poses_.begin()) return PoseStatus::not_known;
  const auto before = after - 1;
  const TimeNs gap_ns = after->stamp_ns - before->stamp_ns;
  if (gap_ns > kMaxPoseGap_ns) return PoseStatus::not_known;
  if (!is_valid(before->T_world_camera) || !is_valid(after->T_world_camera)) return PoseStatus::invalid;
  const double fraction = static_cast<double>(stamp_ns - before->stamp_ns) / static_cast<double>(gap_ns);
  T_world_camera = interpolate(before->T_world_camera, after->T_world_camera, fraction);
  return PoseStatus::ok;
}

}  // namespace g3d::hal
