// SPDX-License-Identifier: Apache-2.0
// A depth camera that flies along a path through a world, and the exact poses that go with it. Frames are rendered when
// they are read: lockstep comes by itself, real time if the pipeline paces the camera thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "hal/depth_camera.hpp"
#include "hal/sim/camera_path.hpp"
#include "hal/sim/sim_renderer.hpp"
#include "hal/sim/world.hpp"

namespace g3d::hal {

struct SimCameraOptions {
  SimRendererOptions renderer;
  double rate_hz = 30.0;                  ///< 0.1..1000
  std::uint64_t first_sequence = 0;       ///< number of the first frame; its stamp is the path's begin whatever this is
  std::optional<std::size_t> max_frames;  ///< stop early
};

/// Frame i is taken at path begin + i / rate.
[[nodiscard]] TimeNs frame_stamp_ns(const CameraPath& path, std::size_t frame, double rate_hz);

/// There are duration * rate of them, and at least one.
class SimCamera : public DepthCamera {
 public:
  SimCamera(World world, CameraPath path, const SimCameraOptions& options);

  [[nodiscard]] const CameraModel& model() const override { return renderer_.camera(); }
  [[nodiscard]] CameraRead read(Frame& out) override;
  [[nodiscard]] std::optional<std::size_t> frame_count() const override { return frame_count_; }

 private:
  SimRenderer renderer_;
  CameraPath path_;
  double rate_hz_;
  std::uint64_t first_sequence_;
  std::size_t frame_count_;
  std::size_t next_frame_ = 0;
};

/// Exact poses of a path; `not_known` before its first waypoint and after its last.
class SimPoses : public PoseSource {
 public:
  explicit SimPoses(CameraPath path) : path_(std::move(path)) {}
  [[nodiscard]] PoseStatus pose_at(TimeNs stamp_ns, Pose& T_world_camera) const override;

 private:
  CameraPath path_;
};

}  // namespace g3d::hal
