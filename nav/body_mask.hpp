// SPDX-License-Identifier: Apache-2.0
// Frames without teammates: where a robot that has just told where it is stands in the picture, readings say nothing of
// the building. Mapped they would leave a smear along its way. What looks out for bodies gets the whole frame all the
// same. One thread. Allocates at construction only.
#pragma once

#include <cstdint>

#include "hal/geometry.hpp"
#include "hal/messages.hpp"
#include "nav/teammates.hpp"

namespace g3d::nav {

class BodyMask {
 public:
  /// `height_m`: of a robot, mast and all.
  BodyMask(const hal::CameraModel& camera, double height_m);

  /// The frame itself if none is in view; else a copy, valid until the next call, in which readings of bodies are too
  /// near to be believed: they are neither hits nor free space.
  [[nodiscard]] const hal::Frame& without_bodies(const hal::Frame& frame, const hal::Pose& T_world_camera,
                                                 const TeamSight& sight);
  /// Readings that were taken out, ever.
  [[nodiscard]] std::uint64_t masked_pixels() const { return masked_pixels_; }

 private:
  struct Window {
    int u0 = 0, v0 = 0, u1 = 0, v1 = 0;  ///< pixels, ends excluded
    bool is_empty = true;
  };
  [[nodiscard]] Window window_of(const hal::RigidTransform& T_camera_world, double x_m, double y_m,
                                 double radius_m) const;
  void copy(const hal::Frame& frame);

  hal::CameraModel camera_;
  double height_m_;
  hal::Frame masked_;
  std::uint64_t masked_pixels_ = 0;
};

}  // namespace g3d::nav
