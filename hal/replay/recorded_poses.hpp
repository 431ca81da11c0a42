// SPDX-License-Identifier: Apache-2.0
// Camera poses out of a recorded trajectory, interpolated to the time of each frame.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/depth_camera.hpp"
#include "hal/replay/trajectory_file.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

/// Between two poses further apart nobody knows where the camera was.
inline constexpr TimeNs kMaxPoseGap_ns = 500'000'000;

class RecordedPoses final : public PoseSource {
 public:
  /// From `poses_file`, or if that is empty from the folder's own trajectory (see find_trajectory).
  static Result<std::unique_ptr<RecordedPoses>> open(const std::string& folder, const std::string& poses_file = {});
  /// `poses` sorted by stamp.
  explicit RecordedPoses(std::vector<StampedPose> poses) : poses_(std::move(poses)) {}

  /// `ok` at a recorded stamp, or between two at most kMaxPoseGap_ns apart; `invalid` if a pose that it needs has a NaN
  /// or no unit quaternion.
  [[nodiscard]] PoseStatus pose_at(TimeNs stamp_ns, Pose& T_world_camera) const override;
  [[nodiscard]] std::size_t count() const { return poses_.size(); }
  /// The first pose that is one; nothing if none is.
  [[nodiscard]] std::optional<Pose> first() const;

 private:
  std::vector<StampedPose> poses_;
};

}  // namespace g3d::hal
