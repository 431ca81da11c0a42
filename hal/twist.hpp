// SPDX-License-Identifier: Apache-2.0
// Motion on the floor. Base frame: origin on the floor between the wheels, x forward, y left; world: x y z as
// elsewhere.
#pragma once

namespace g3d::hal {

/// Velocity of the base in its own frame.
struct Twist {
  double forward_mps = 0.0;
  double turn_radps = 0.0;  ///< positive = counter-clockwise (to the left)
  bool operator==(const Twist&) const = default;
};

/// T_world_base on a flat floor.
struct PlanarPose {
  double x_m = 0.0;
  double y_m = 0.0;
  double heading_rad = 0.0;  ///< 0 = along world x, counter-clockwise, in (-pi, pi]
  bool operator==(const PlanarPose&) const = default;
};

}  // namespace g3d::hal
