// SPDX-License-Identifier: Apache-2.0
// What odometry always gets wrong in the same way: a gyro that turns by itself, a wheel that is larger than it is said
// to be. Alignment sees both as corrections that do not average out; what has been learnt while the scene held the pose
// is made good where it does not, in halls and corridors. Thread: one. Allocates nothing.
#pragma once

#include "hal/geometry.hpp"
#include "mapper/align/normal_equations.hpp"

namespace g3d::mapper::align {

class OdometryHabits {
 public:
  /// Where odometry's step from `last` leads when its habits are made good. `step`: in the frame of `last`.
  [[nodiscard]] hal::Pose predicted(const hal::Pose& last, const hal::Pose& step, double dt_s) const;
  /// Such a prediction, over a time and a way in the world, was corrected by `correction`. What is held says nothing.
  void learn(const Vector6& correction, const std::array<double, 3>& way_m, double time_s, bool holds_shift,
             bool holds_turn);

  /// Of the heading, to be added. 0 while it is so little that alignment itself may have made it up.
  [[nodiscard]] double turn_radps() const;
  /// Of the way: its true length is so much longer, as a fraction. 0 likewise.
  [[nodiscard]] double stretch() const;

 private:
  double turn_radps_ = 0.0;  ///< as estimated
  double turn_time_s_ = 0.0;
  double stretch_ = 0.0;
  double way_m_ = 0.0;
};

}  // namespace g3d::mapper::align
