// SPDX-License-Identifier: Apache-2.0
// What one Kobuki packet says, decoded (kobuki_documentation, protocol). Only packets that were valid as a whole and
// plausible after the one before become a Feedback.
#pragma once

#include <array>
#include <cstdint>

#include "hal/messages.hpp"

namespace g3d::hal::kobuki {

inline constexpr std::uint8_t kBumperRight = 1, kBumperCentre = 2, kBumperLeft = 4;
inline constexpr std::uint8_t kWheelDropRight = 1, kWheelDropLeft = 2;
inline constexpr std::uint8_t kCliffRight = 1, kCliffCentre = 2, kCliffLeft = 4;
inline constexpr std::uint8_t kOverCurrentLeft = 1, kOverCurrentRight = 2;  ///< sic: the reverse of the other flags

inline constexpr double kWheelBase_m = 0.230;
inline constexpr double kWheelRadius_m = 0.035;
inline constexpr double kMetresPerTick = 8.5292090497737556e-05;
inline constexpr double kBodyRadius_m = 0.178;
inline constexpr double kMaxSpeed_mps = 0.70;
inline constexpr double kMaxTurn_radps = 1.9;  ///< above 110 deg/s the gyro degrades
inline constexpr TimeNs kPacketPeriod_ns = 20'000'000;

struct GyroSample {
  std::int16_t x = 0;  ///< raw digits of 0.00875 deg/s
  std::int16_t y = 0;
  std::int16_t z = 0;
};

struct Feedback {
  TimeNs received_ns = 0;          ///< our clock, when the packet was complete
  std::uint16_t timestamp_ms = 0;  ///< the base's clock, wraps at 65536
  std::uint8_t bumper = 0;
  std::uint8_t wheel_drop = 0;
  std::uint8_t cliff = 0;
  std::uint16_t left_encoder_ticks = 0;  ///< wraps at 65536
  std::uint16_t right_encoder_ticks = 0;
  std::int8_t left_pwm = 0;
  std::int8_t right_pwm = 0;
  std::uint8_t buttons = 0;
  std::uint8_t charger = 0;
  std::uint8_t battery_decivolts = 0;
  std::uint8_t over_current = 0;
  std::array<std::uint8_t, 3> dock_ir{};       ///< right, centre, left
  std::int16_t gyro_angle_cdeg = 0;            ///< 0.01 deg, wraps at +-180
  std::int16_t gyro_rate_cdegps = 0;           ///< 0.01 deg/s
  std::array<std::uint16_t, 3> cliff_adc{};    ///< right, centre, left
  std::array<std::uint8_t, 2> current_10mA{};  ///< left, right
  std::uint8_t gyro_frame_id = 0;
  std::uint8_t gyro_sample_count = 0;  ///< 0 if the packet had no raw gyro
  std::array<GyroSample, 8> gyro{};
  std::uint16_t digital_in = 0;
  std::array<std::uint16_t, 4> analog_in{};
};

/// Answers to requests; each arrives in some later packet.
struct DeviceInfo {
  bool has_hardware = false, has_firmware = false, has_udid = false;
  std::array<std::uint8_t, 3> hardware{};  ///< major, minor, patch
  std::array<std::uint8_t, 3> firmware{};
  std::array<std::uint32_t, 3> udid{};
};

}  // namespace g3d::hal::kobuki
