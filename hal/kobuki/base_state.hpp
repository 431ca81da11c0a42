// SPDX-License-Identifier: Apache-2.0
// What the base driver knows, in one plain value that crosses threads through hal::Latest.
#pragma once

#include <array>
#include <cstdint>

#include "hal/kobuki/battery.hpp"
#include "hal/kobuki/rejects.hpp"
#include "hal/safety.hpp"
#include "hal/twist.hpp"

namespace g3d::hal::kobuki {

struct BaseState {
  TimeNs stamp_ns = 0;     ///< when this was written
  TimeNs feedback_ns = 0;  ///< when the last packet was complete; 0 before the first

  // Motion
  PlanarPose T_world_base;    ///< odometry; the world begins where the base stood at its first packet
  Twist velocity;             ///< as odometry measured it
  double path_m = 0.0;        ///< way of the base's centre so far
  double rotation_rad = 0.0;  ///< sum of |turns|
  Twist commanded;            ///< what was sent last, after all limits

  // Safety
  Conditions conditions;
  Verdict verdict;
  std::uint8_t bumper = 0;      ///< kBumper*: sides of the contact that still holds, else 0
  std::uint8_t cliff = 0;       ///< kCliff*, the same
  std::uint8_t wheel_drop = 0;  ///< kWheelDrop*, the same
  bool was_ready = false;       ///< has been allowed to drive at least once
  /// What limited forward motion last since it was first ready, and when that was; `count_`: nothing yet.
  Condition last_reason = Condition::count_;
  TimeNs last_reason_ns = 0;

  // Device
  BatteryLevel battery_level = BatteryLevel::healthy;
  double battery_v = 0.0;
  double battery_charge = 0.0;  ///< 0..1
  double energy_left_s = 0.0;   ///< of driving, until the battery is empty; may be infinite
  PowerSource power = PowerSource::battery;
  DeviceInfo device;
  std::uint8_t buttons = 0;
  std::array<std::uint8_t, 3> dock_ir{};

  // Counters
  std::uint64_t packets = 0;
  std::uint64_t received_bytes = 0;
  RejectCounts rejects;
  std::uint64_t restarts = 0;        ///< of the base, or of the line
  std::uint64_t ticks = 0;           ///< periods of 20 ms for which a command was sent
  std::uint64_t urgent_stops = 0;    ///< zeros that did not wait for the next tick
  std::uint64_t refused_wishes = 0;  ///< commands that were not numbers
  /// How often each condition began to hold since the base was first ready.
  std::array<std::uint64_t, kConditionCount> began{};
};

}  // namespace g3d::hal::kobuki
