// SPDX-License-Identifier: Apache-2.0
// Something wired to the robot that may stop it: an emergency stop at a GPIO line, a node on the CAN bus. The thread
// that drives the base asks it itself, every other millisecond, so that no other thread, lock or queue stands between
// the switch and the latches of safety_latches.hpp.
#pragma once

#include <cstdint>

#include "hal/messages.hpp"
#include "hal/safety.hpp"
#include "hal/twist.hpp"

namespace g3d::hal {

enum class StopWord : std::uint8_t {
  go,
  not_yet,  ///< never seen well since the start: the robot stands, and drives by itself once it is seen
  stop,     ///< an emergency stop: holds until a person says resume
};
/// Of two devices the stricter word counts.
[[nodiscard]] constexpr StopWord stricter(StopWord a, StopWord b) { return a > b ? a : b; }

/// What a device may show of the robot.
struct SafetyNews {
  SafetyState state = SafetyState::stand;
  Conditions conditions;
  Twist commanded;
  double battery_v = 0.0;
};

class SafetyDevice {
 public:
  virtual ~SafetyDevice() = default;
  /// The base's thread, at least every few milliseconds. Never waits, locks or allocates. `stop` also for a moment that
  /// began and ended since the last call.
  [[nodiscard]] virtual StopWord look(TimeNs now_ns) = 0;
  /// The same thread, after each look.
  virtual void show(const SafetyNews& news, TimeNs now_ns) = 0;
  /// The same thread, once, at a good end.
  virtual void say_farewell(TimeNs now_ns) = 0;
};

}  // namespace g3d::hal
