// SPDX-License-Identifier: Apache-2.0
// What the base may do, from what is wrong at the moment: one table, one pure function. Every condition takes something
// away and none gives anything back, so more that is wrong never allows more motion. Conditions come from
// safety_latches.hpp; this file knows neither time nor threads.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/twist.hpp"

namespace g3d::hal {

/// What may be wrong. In the order in which one is named as the reason when several hold.
enum class Condition : std::uint8_t {
  e_stop,          ///< emergency stop pressed, or released and not yet resumed by a person
  wheel_drop,      ///< a wheel hangs, or both have not yet been up for long enough
  silent_base,     ///< no feedback, or not enough of it since the silence
  late_base,       ///< feedback arrives, but it is old
  late_thread,     ///< the thread that runs this table was late itself
  stale_command,   ///< nobody has commanded a motion of late
  silent_camera,   ///< no image of late
  wrong_firmware,  ///< the base speaks a protocol that was not written for
  battery_empty,
  dead_wheel,    ///< a motor is driven and its encoder does not count: the odometry is wrong
  over_current,  ///< a motor draws more than its drive gives
  cliff,
  bumper,
  rear_unknown,  ///< nothing says that the floor behind is free: the camera does not look there
  battery_low,
  count_,
};
inline constexpr std::size_t kConditionCount = static_cast<std::size_t>(Condition::count_);
[[nodiscard]] const char* to_string(Condition condition);

/// A set of conditions.
struct Conditions {
  std::uint32_t bits = 0;
  [[nodiscard]] constexpr bool has(Condition c) const { return (bits >> static_cast<unsigned>(c) & 1U) != 0; }
  constexpr void set(Condition c, bool on = true) {
    const std::uint32_t bit = 1U << static_cast<unsigned>(c);
    bits = on ? bits | bit : bits & ~bit;
  }
  [[nodiscard]] constexpr bool none() const { return bits == 0; }
  bool operator==(const Conditions&) const = default;
};

/// Largest speeds in each direction, none negative; 0 forbids the direction.
struct Allowance {
  double forward_mps = 0.0;
  double backward_mps = 0.0;
  double turn_radps = 0.0;
  bool operator==(const Allowance&) const = default;
};

/// The allowance in one word.
enum class SafetyState : std::uint8_t {
  stand,         ///< no motion at all
  turn_only,     ///< on the spot
  back_off,      ///< straight back, slowly
  back_or_turn,  ///< not forward
  careful,       ///< any direction, slower than usual
  free,
  count_,
};
[[nodiscard]] const char* to_string(SafetyState state);

struct Verdict {
  SafetyState state = SafetyState::stand;
  Allowance allowance;
  /// The first condition that holds and takes away forward motion, else `count_`.
  Condition reason = Condition::count_;
};

/// A row of the table: what one condition leaves.
struct SafetyRow {
  Condition condition;
  Allowance allowance;
};
/// All rows, in the order of the conditions.
[[nodiscard]] std::span<const SafetyRow, kConditionCount> safety_table();
/// What nothing wrong leaves.
[[nodiscard]] const Allowance& free_allowance();

/// Any thread. The direction-wise minimum of the rows whose conditions hold.
[[nodiscard]] Verdict judge(Conditions conditions);

/// Any thread. `wanted` scaled down until all of it is allowed, forward and turn alike, so that the curvature stays;
/// a motion with any part in a forbidden direction is therefore a stop. So is one that is not finite.
[[nodiscard]] Twist permit(const Twist& wanted, const Allowance& allowance);

}  // namespace g3d::hal
