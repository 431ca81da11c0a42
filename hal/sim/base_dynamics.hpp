// SPDX-License-Identifier: Apache-2.0
// The wheels of a Kobuki: from the commanded speed and radius to what each wheel does in the next millisecond. Speeds
// follow the command with a first-order lag and a bounded acceleration, as wheels under a speed controller do.
#pragma once

#include <cstdint>

#include "hal/twist.hpp"

namespace g3d::hal {

struct BaseDynamicsOptions {
  double motor_lag_s = 0.04;                ///< time constant of the speed controller; 0: none
  double max_acceleration_mps2 = 2.0;       ///< of each wheel's rim; speeding up and slowing down
  double max_wheel_speed_mps = 0.70 + 0.3;  ///< what the motors can do: full speed in a curve
};

/// Way or speed of both wheels.
struct WheelPair {
  double left = 0.0;
  double right = 0.0;
  bool operator==(const WheelPair&) const = default;
};

/// Wheel speeds in m/s for the two numbers of the base control command (kobuki_documentation, protocol): radius 0 is
/// straight, 1 and -1 turn on the spot, else the speed is that of the outer wheel and the centre lies `radius` to the
/// left.
[[nodiscard]] WheelPair wheels_for_command(std::int16_t speed_mmps, std::int16_t radius_mm);
[[nodiscard]] Twist twist_of(const WheelPair& speeds_mps);

class BaseDynamics {
 public:
  explicit BaseDynamics(const BaseDynamicsOptions& options = {}) : options_(options) {}

  void command(std::int16_t speed_mmps, std::int16_t radius_mm);
  /// Way of each wheel over the next `dt_s` (1..20 ms), metres, if nothing blocks it.
  [[nodiscard]] WheelPair step(double dt_s);
  /// Something from outside holds the wheels: from now on they turn this fast.
  void force_speeds(const WheelPair& speeds_mps) { speeds_mps_ = speeds_mps; }

  [[nodiscard]] const WheelPair& speeds_mps() const { return speeds_mps_; }
  [[nodiscard]] const WheelPair& target_mps() const { return target_mps_; }

 private:
  BaseDynamicsOptions options_;
  WheelPair target_mps_;
  WheelPair speeds_mps_;
};

}  // namespace g3d::hal
