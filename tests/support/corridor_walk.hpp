// SPDX-License-Identifier: Apache-2.0
// A long walk in pictures of a few pixels: a corridor along x, 2.4 m wide and 2.4 m high, with a niche every 4 m, and a
// camera that walks up and down in it, looking left and right. For maps that must hold more than fits into memory.
#pragma once

#include "hal/messages.hpp"

namespace g3d::tests {

struct CorridorWalk {
  double length_m = 32.0;
  double step_m = 0.2;

  [[nodiscard]] static hal::CameraModel camera();
  /// Up and down and up again, without end.
  [[nodiscard]] hal::Pose pose(int frame) const;
  void draw(const hal::Pose& T_world_camera, hal::Frame& out) const;
  [[nodiscard]] int frames_per_turn() const { return static_cast<int>(2.0 * length_m / step_m); }
};

}  // namespace g3d::tests
