// SPDX-License-Identifier: Apache-2.0
// What of a building a camera has been shown so far, told from outside: the observable cells (observable.hpp) that a
// depth image, taken where the camera really was, shows to be free or a wall. No robot's map is asked.
#pragma once

#include <atomic>
#include <vector>

#include "hal/messages.hpp"
#include "hal/sim/observable.hpp"

namespace g3d::hal {

class SeenCells {
 public:
  /// `observable` outlives this.
  explicit SeenCells(const Observable& observable);

  /// One frame, and where it was taken; some hundred of its pixels are followed. One thread.
  void look(const Frame& frame, const CameraModel& camera, const Pose& T_world_camera);
  /// 0..1 of what can be seen; 1 if nothing can. Any thread.
  [[nodiscard]] double fraction() const;
  /// Of several cameras in one building, together.
  [[nodiscard]] static double fraction(const std::vector<const SeenCells*>& cameras);

 private:
  void mark(double x_m, double y_m, SeenCell what);

  const Observable* observable_;
  std::vector<std::atomic<std::uint8_t>> seen_;
};

}  // namespace g3d::hal
