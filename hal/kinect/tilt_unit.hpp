// SPDX-License-Identifier: Apache-2.0
// The Kinect 360's foot: motor, light and accelerometer (USB 045e:02b0). The protocol is that of the OpenKinect
// project's documentation: vendor requests 0x31 (tilt, half degrees against the horizon), 0x06 (light), 0x32 (ten bytes
// of state). An answer that cannot be is an error, and changes nothing.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "hal/kinect/usb_control.hpp"

namespace g3d::hal::kinect {

inline constexpr std::uint16_t kMicrosoft = 0x045e;
inline constexpr std::uint16_t kKinectFoot = 0x02b0;
/// Beyond, the motor runs against its stop.
inline constexpr double kMostTilt_deg = 27.0;

enum class Light : std::uint8_t {
  off = 0,
  green = 1,
  red = 2,
  yellow = 3,
  blinking_green = 4,
  blinking_red_yellow = 6
};

struct TiltState {
  /// What the sensor's frame feels, in g: about 0, 1, 0 when it looks level. x to its left, y up, z ahead.
  std::array<double, 3> acceleration_g{};
  double tilt_deg = 0.0;   ///< as the motor knows it
  bool knows_tilt = true;  ///< while it moves it does not
  bool is_moving = false;
  bool is_at_stop = false;
};

/// The ten bytes of a state. Errors: truncated, malformed (what no foot can say).
[[nodiscard]] Result<TiltState> parse_tilt_state(std::span<const std::uint8_t> answer);

/// One thread.
class TiltUnit {
 public:
  explicit TiltUnit(std::unique_ptr<UsbControl> usb) : usb_(std::move(usb)) {}
  /// Against the horizon; within +-kMostTilt_deg. Returns at once, the motor moves for a second or more.
  [[nodiscard]] Result<void> tilt_to(double degrees);
  [[nodiscard]] Result<void> show(Light light);
  [[nodiscard]] Result<TiltState> state();

 private:
  std::unique_ptr<UsbControl> usb_;
};

}  // namespace g3d::hal::kinect
