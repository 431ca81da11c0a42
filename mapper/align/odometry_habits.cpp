// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/odometry_habits.hpp"

#include <algorithm>
#include <cmath>

#include "mapper/align/pose_step.hpp"

namespace g3d::mapper::align {
namespace {

// So much evidence that there are no habits is there from the start: a walk of half a degree per root second hides a
// bias of a third of a degree for some seconds.
constexpr double kDoubt_s = 5.0;
constexpr double kDoubt_m = 1.0;
// And so far back it is remembered: gyros warm up.
constexpr double kMemory_s = 60.0;
constexpr double kMemory_m = 20.0;
constexpr double kMost_radps = 0.02;
constexpr double kMostStretch = 0.08;
// Coarse images pull to one side, too: half of a degree in ten seconds has nothing to do with the wheels.
constexpr double kLeast_radps = 0.001;
constexpr double kLeastStretch = 0.004;

/// Nothing up to `least`, all from twice as much on, and no step between.
double beyond(double value, double least) {
  const double size = std::abs(value);
  return std::copysign(size < 2.0 * least ? std::max(0.0, 2.0 * (size - least)) : size, value);
}

}  // namespace

double OdometryHabits::turn_radps() const { return beyond(turn_radps_, kLeast_radps); }
double OdometryHabits::stretch() const { return beyond(stretch_, kLeastStretch); }

hal::Pose OdometryHabits::predicted(const hal::Pose& last, const hal::Pose& step, double dt_s) const {
  hal::Pose stretched = step;
  for (double& t_m : stretched.translation_m) t_m *= 1.0 + stretch();
  return moved(hal::compose(last, stretched), {0.0, 0.0, 0.0, 0.0, 0.0, turn_radps() * dt_s});
}

// Means of what each second and each metre was off by, the oldest forgotten.
void OdometryHabits::learn(const Vector6& correction, const std::array<double, 3>& way_m, double time_s,
                           bool holds_shift, bool holds_turn) {
  if (!holds_turn && time_s > 0.0) {
    turn_time_s_ = std::min(turn_time_s_ + time_s, kMemory_s);
    const double measured_radps = turn_radps() + correction[5] / time_s;
    turn_radps_ += (measured_radps - turn_radps_) * time_s / (turn_time_s_ + kDoubt_s);
    turn_radps_ = std::clamp(turn_radps_, -kMost_radps, kMost_radps);
  }
  const double length_m = shift_of({way_m[0], way_m[1], way_m[2], 0.0, 0.0, 0.0});
  if (!holds_shift && length_m > 0.0) {
    way_m_ = std::min(way_m_ + length_m, kMemory_m);
    const double along_m = (correction[0] * way_m[0] + correction[1] * way_m[1] + correction[2] * way_m[2]) / length_m;
    const double measured = stretch() + along_m / length_m;
    stretch_ += (measured - stretch_) * length_m / (way_m_ + kDoubt_m);
    stretch_ = std::clamp(stretch_, -kMostStretch, kMostStretch);
  }
}

}  // namespace g3d::mapper::align
