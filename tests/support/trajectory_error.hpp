// SPDX-License-Identifier: Apache-2.0
// How far an estimated trajectory is from the true one, the first poses being the same (no fit).
#pragma once

#include <span>

#include "hal/replay/trajectory_file.hpp"

namespace g3d::test {

struct TrajectoryError {
  double ate_m = 0.0;         ///< root mean square of the distances
  double turn_rms_deg = 0.0;  ///< root mean square of the angles
  double last_turn_deg = 0.0;
  double rpe_turn_deg = 0.0;  ///< root mean square of the angle errors over steps of 1 s
  double rpe_shift_m = 0.0;
};

/// Both of the same length, with the same stamps.
[[nodiscard]] TrajectoryError trajectory_error(std::span<const hal::StampedPose> truth,
                                               std::span<const hal::StampedPose> estimate);

}  // namespace g3d::test
