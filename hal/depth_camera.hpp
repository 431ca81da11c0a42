// SPDX-License-Identifier: Apache-2.0
// Where depth frames and their poses come from: a Kinect, a recorded folder, a simulated world.
#pragma once

#include <optional>
#include <string>

#include "hal/messages.hpp"

namespace g3d::hal {

enum class CameraEvent {
  frame,    ///< `out` holds a new frame
  dropped,  ///< the source delivered a frame that cannot be used; see CameraRead::reason
  end,      ///< no frame will ever come again
};

struct CameraRead {
  CameraEvent event = CameraEvent::end;
  DropReason reason = DropReason::unreadable_depth;  ///< valid when event == dropped
};

/// One depth camera. Called by the camera thread alone.
class DepthCamera {
 public:
  virtual ~DepthCamera() = default;
  [[nodiscard]] virtual const CameraModel& model() const = 0;
  /// Fills `out` (storage already sized for model()) with the next frame. Files: may block on the disk.
  [[nodiscard]] virtual CameraRead read(Frame& out) = 0;
  /// How many frames will come, if the source knows (for the progress bar).
  [[nodiscard]] virtual std::optional<std::size_t> frame_count() const { return std::nullopt; }
  /// What went wrong last, for the user; empty if nothing did.
  [[nodiscard]] virtual std::string last_error() const { return {}; }
};

enum class PoseStatus { ok, not_known, invalid };

/// Poses of the camera over time. Called by the pose thread alone.
class PoseSource {
 public:
  virtual ~PoseSource() = default;
  /// T_world_camera at `stamp_ns`, interpolated between the neighbours; `not_known` outside of what was recorded.
  [[nodiscard]] virtual PoseStatus pose_at(TimeNs stamp_ns, Pose& T_world_camera) const = 0;
};

}  // namespace g3d::hal
