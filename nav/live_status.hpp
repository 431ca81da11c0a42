// SPDX-License-Identifier: Apache-2.0
// How a robot is at the moment, for people who look on while it runs: one plain value that crosses threads, and the
// JSON object that `g3dmap tell PATH status` prints.
#pragma once

#include <cstdint>
#include <string>

#include "hal/kobuki/base_state.hpp"
#include "nav/mission.hpp"
#include "nav/navigator.hpp"

namespace g3d::nav {

struct LiveStatus {
  hal::TimeNs stamp_ns = 0;
  double time_s = 0.0;     ///< since the first pose
  double coverage = -1.0;  ///< 0..1 of what can be seen; below 0: nobody knows the building
  double path_m = 0.0;
  double turned_rad = 0.0;  ///< sum of all turning
  MissionState state = MissionState::starting;
  MissionState purpose = MissionState::starting;  ///< while held: what resume goes back to
  hal::PlanarPose T_world_base;
  // The base
  double battery_v = 0.0;
  double battery_charge = 0.0;  ///< 0..1
  double energy_left_s = 0.0;   ///< of driving; may be infinite
  hal::kobuki::BatteryLevel battery_level = hal::kobuki::BatteryLevel::healthy;
  hal::SafetyState safety = hal::SafetyState::stand;
  hal::Allowance allowance;
  hal::Condition limited_by = hal::Condition::count_;   ///< now; `count_`: nothing
  hal::Condition last_reason = hal::Condition::count_;  ///< the last that limited forward motion
  double last_reason_s = 0.0;                           ///< how long ago
  std::uint64_t words = 0;                              ///< of people, taken so far
};

[[nodiscard]] LiveStatus status_of(const Navigator& navigator, const hal::kobuki::BaseState& base,
                                   const hal::PlanarPose& T_world_base, hal::TimeNs now);
/// One object with a final newline.
[[nodiscard]] std::string to_json(const LiveStatus& status);

}  // namespace g3d::nav
