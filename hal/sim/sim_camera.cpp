// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/sim_camera.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace g3d::hal {
namespace {

std::size_t count_frames(const CameraPath& path, const SimCameraOptions& options) {
  const double duration_s = static_cast<double>(path.end_ns() - path.begin_ns()) / 1e9;
  // A whole number of frames must not lose one to rounding.
  const auto frames = static_cast<std::size_t>(std::floor(duration_s * options.rate_hz + 1e-6));
  return std::min(std::max<std::size_t>(frames, 1), options.max_frames.value_or(frames + 1));
}

}  // namespace

TimeNs frame_stamp_ns(const CameraPath& path, std::size_t frame, double rate_hz) {
  return path.begin_ns() + static_cast<TimeNs>(std::llround(static_cast<double>(frame) * 1e9 / rate_hz));
}

SimCamera::SimCamera(World world, CameraPath path, const SimCameraOptions& options)
    : renderer_(std::move(world), options.renderer),
      path_(std::move(path)),
      rate_hz_(options.rate_hz),
      first_sequence_(options.first_sequence),
      frame_count_(count_frames(path_, options)) {}

CameraRead SimCamera::read(Frame& out) {
  if (next_frame_ == frame_count_) return {CameraEvent::end, {}};
  const TimeNs stamp_ns = frame_stamp_ns(path_, next_frame_, rate_hz_);
  renderer_.render(path_.pose_at(stamp_ns), stamp_ns, first_sequence_ + next_frame_, out);
  ++next_frame_;
  return {CameraEvent::frame, {}};
}

PoseStatus SimPoses::pose_at(TimeNs stamp_ns, Pose& T_world_camera) const {
  if (stamp_ns < path_.begin_ns() || stamp_ns > path_.end_ns()) return PoseStatus::not_known;
  T_world_camera = path_.pose_at(stamp_ns);
  return PoseStatus::ok;
}

}  // namespace g3d::hal
