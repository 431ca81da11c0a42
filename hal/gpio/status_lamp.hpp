// SPDX-License-Identifier: Apache-2.0
// What one lamp says: steady, it may drive; blinking slowly, it stands or is held back; blinking fast, an emergency
// stop holds; dark, no program drives it.
#pragma once

#include "hal/safety_device.hpp"

namespace g3d::hal {

[[nodiscard]] inline bool lamp_is_lit(const SafetyNews& news, TimeNs now_ns) {
  constexpr TimeNs kFast_ns = 125'000'000, kSlow_ns = 500'000'000;  // half a period each
  if (news.conditions.has(Condition::e_stop)) return now_ns / kFast_ns % 2 == 0;
  if (news.state == SafetyState::free || news.state == SafetyState::careful) return true;
  return now_ns / kSlow_ns % 2 == 0;
}

}  // namespace g3d::hal
