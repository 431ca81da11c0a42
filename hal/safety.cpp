// SPDX-License-Identifier: Apache-2.0
#include "hal/safety.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::hal {
namespace {

constexpr Allowance kFree{0.70, 0.20, 1.90};  // the Kobuki's top speed; its gyro degrades above 110 deg/s
constexpr Allowance kStand{0.0, 0.0, 0.0};
// A touch is left at the speed at which the base can still be stopped by hand. The body is round, so turning on the
// spot does not press against what was touched.
constexpr Allowance kNotForward{0.0, 0.10, 0.8};
// At an edge turning on the spot would move the wheels, which lie beside the sensors, over it.
constexpr Allowance kBackOff{0.0, 0.10, 0.0};
constexpr Allowance kNotBackward{kFree.forward_mps, 0.0, kFree.turn_radps};
constexpr Allowance kCareful{0.30, 0.10, 1.0};

constexpr std::array<SafetyRow, kConditionCount> kTable{{
    {Condition::e_stop, kStand},
    {Condition::wheel_drop, kStand},
    {Condition::silent_base, kStand},
    {Condition::late_base, kStand},
    {Condition::late_thread, kStand},
    {Condition::stale_command, kStand},
    {Condition::silent_camera, kStand},
    {Condition::wrong_firmware, kStand},
    {Condition::battery_empty, kStand},
    {Condition::dead_wheel, kStand},
    {Condition::over_current, kStand},
    {Condition::cliff, kBackOff},
    {Condition::bumper, kNotForward},
    {Condition::rear_unknown, kNotBackward},
    {Condition::battery_low, kCareful},
}};

constexpr bool rows_stand_in_order() {
  for (std::size_t i = 0; i < kConditionCount; ++i) {
    if (kTable[i].condition != static_cast<Condition>(i)) return false;
  }
  return true;
}
static_assert(rows_stand_in_order(), "the table is indexed by condition");

SafetyState name_of(const Allowance& a) {
  if (a.forward_mps > 0.0) return a.forward_mps < kFree.forward_mps ? SafetyState::careful : SafetyState::free;
  if (a.backward_mps > 0.0) return a.turn_radps > 0.0 ? SafetyState::back_or_turn : SafetyState::back_off;
  return a.turn_radps > 0.0 ? SafetyState::turn_only : SafetyState::stand;
}

}  // namespace

const char* to_string(Condition condition) {
  switch (condition) {
    case Condition::e_stop:
      return "e_stop";
    case Condition::wheel_drop:
      return "wheel_drop";
    case Condition::silent_base:
      return "silent_base";
    case Condition::late_base:
      return "late_base";
    case Condition::late_thread:
      return "late_thread";
    case Condition::stale_command:
      return "stale_command";
    case Condition::silent_camera:
      return "silent_camera";
    case Condition::wrong_firmware:
      return "wrong_firmware";
    case Condition::battery_empty:
      return "battery_empty";
    case Condition::dead_wheel:
      return "dead_wheel";
    case Condition::over_current:
      return "over_current";
    case Condition::cliff:
      return "cliff";
    case Condition::bumper:
      return "bumper";
    case Condition::rear_unknown:
      return "rear_unknown";
    case Condition::battery_low:
      return "battery_low";
    case Condition::count_:
      break;
  }
  return "none";
}

const char* to_string(SafetyState state) {
  switch (state) {
    case SafetyState::stand:
      return "stand";
    case SafetyState::turn_only:
      return "turn_only";
    case SafetyState::back_off:
      return "back_off";
    case SafetyState::back_or_turn:
      return "back_or_turn";
    case SafetyState::careful:
      return "careful";
    case SafetyState::free:
      return "free";
    case SafetyState::count_:
      break;
  }
  return "unknown";
}

std::span<const SafetyRow, kConditionCount> safety_table() { return kTable; }
const Allowance& free_allowance() { return kFree; }

Verdict judge(Conditions conditions) {
  Verdict verdict;
  Allowance& left = verdict.allowance;
  left = kFree;
  for (const SafetyRow& row : kTable) {
    if (!conditions.has(row.condition)) continue;
    if (verdict.reason == Condition::count_ && row.allowance.forward_mps < kFree.forward_mps) {
      verdict.reason = row.condition;
    }
    left.forward_mps = std::min(left.forward_mps, row.allowance.forward_mps);
    left.backward_mps = std::min(left.backward_mps, row.allowance.backward_mps);
    left.turn_radps = std::min(left.turn_radps, row.allowance.turn_radps);
  }
  verdict.state = name_of(left);
  return verdict;
}

Twist permit(const Twist& wanted, const Allowance& allowance) {
  if (!std::isfinite(wanted.forward_mps) || !std::isfinite(wanted.turn_radps)) return {};
  const double forward_limit_mps = wanted.forward_mps < 0.0 ? allowance.backward_mps : allowance.forward_mps;
  double scale = 1.0;
  if (std::abs(wanted.forward_mps) > forward_limit_mps) {
    scale = std::min(scale, forward_limit_mps / std::abs(wanted.forward_mps));
  }
  if (std::abs(wanted.turn_radps) > allowance.turn_radps) {
    scale = std::min(scale, allowance.turn_radps / std::abs(wanted.turn_radps));
  }
  if (!(scale > 0.0)) return {};
  // Dividing and multiplying rounds: what was scaled down to a limit must not come out above it.
  return {std::clamp(wanted.forward_mps * scale, -allowance.backward_mps, allowance.forward_mps),
          std::clamp(wanted.turn_radps * scale, -allowance.turn_radps, allowance.turn_radps)};
}

}  // namespace g3d::hal
