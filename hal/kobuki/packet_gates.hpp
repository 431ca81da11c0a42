// SPDX-License-Identifier: Apache-2.0
// What a Kobuki can say. The 8-bit checksum lets 1 in 256 corrupted frames pass: these limits, of one packet alone and
// of one after another, bound what such a frame can do.
#pragma once

#include <optional>

#include "hal/kobuki/feedback.hpp"
#include "hal/kobuki/rejects.hpp"

namespace g3d::hal::kobuki {

inline constexpr int kMinBattery_decivolts = 90, kMaxBattery_decivolts = 180;
inline constexpr int kMaxTimeStep_ms = 200;
/// Half as fast again as the base can drive.
inline constexpr double kMaxWheelSpeed_mps = 1.5 * kMaxSpeed_mps;
/// The gyro measures up to 250 deg/s; stamps may be some ms off.
inline constexpr int kMaxTurn_cdegps = 30'000;

/// Later minus earlier, as the base's counters wrap.
[[nodiscard]] inline int ms_between(const Feedback& from, const Feedback& to) {
  return static_cast<std::uint16_t>(to.timestamp_ms - from.timestamp_ms);
}
[[nodiscard]] inline int ticks_between(std::uint16_t from, std::uint16_t to) {
  return static_cast<std::int16_t>(to - from);
}
/// In (-18000, 18000].
[[nodiscard]] int angle_between_cdeg(std::int16_t from, std::int16_t to);

/// Limits of a step that took `elapsed_ms` >= 0.
[[nodiscard]] int max_ticks_in(int elapsed_ms);
[[nodiscard]] int max_angle_in_cdeg(int elapsed_ms);

/// Why `feedback` cannot be, whatever came before.
[[nodiscard]] std::optional<Reject> impossible_value(const Feedback& feedback);
/// Why `to` cannot follow `from` on the same base without a restart or a long silence between them.
[[nodiscard]] std::optional<Reject> impossible_step(const Feedback& from, const Feedback& to);

}  // namespace g3d::hal::kobuki
