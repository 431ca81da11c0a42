// SPDX-License-Identifier: Apache-2.0
// Poses for a recording whose camera nobody tracked: it is taken to stand where it started, until an alignment says
// otherwise.
#pragma once

#include "hal/depth_camera.hpp"

namespace g3d::hal {

class StandingPose final : public PoseSource {
 public:
  explicit StandingPose(const Pose& T_world_camera) : pose_(T_world_camera) {}
  [[nodiscard]] PoseStatus pose_at(TimeNs /*stamp_ns*/, Pose& T_world_camera) const override {
    T_world_camera = pose_;
    return PoseStatus::ok;
  }

 private:
  Pose pose_;
};

}  // namespace g3d::hal
