// SPDX-License-Identifier: Apache-2.0
// What is to go wrong in a simulated run, and when: one part of the robot, one kind of fault, from one time to another.
// What a kind means for a part stands with that part: camera_faults.hpp, base_trouble.hpp, disk_faults.hpp.
#pragma once

#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include "hal/messages.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

enum class FaultPart : std::uint8_t { camera, odometry, line, disk, count_ };
enum class FaultKind : std::uint8_t { none, off, stuck, garbage, wrong, slow, delayed, intermittent, count_ };
[[nodiscard]] const char* to_string(FaultPart part);
[[nodiscard]] const char* to_string(FaultKind kind);

struct PlannedFault {
  static constexpr TimeNs kForEver_ns = std::numeric_limits<TimeNs>::max();
  FaultPart part = FaultPart::camera;
  FaultKind kind = FaultKind::none;
  TimeNs from_ns = 0;  ///< since the simulation began
  TimeNs to_ns = kForEver_ns;
};

using FaultPlan = std::vector<PlannedFault>;

/// "PART:KIND@FROM+SECONDS", such as camera:stuck@20+5; without +SECONDS for ever, without @FROM from the start.
/// Errors: bad_usage, with what is allowed.
[[nodiscard]] Result<PlannedFault> parse_fault(std::string_view text);

/// What is wrong with a part at a moment.
struct FaultNow {
  FaultKind kind = FaultKind::none;
  TimeNs since_ns = 0;  ///< how long it has been so
};
/// Where several hold, the last one in the plan.
[[nodiscard]] FaultNow fault_at(const FaultPlan& plan, FaultPart part, TimeNs now_ns);
[[nodiscard]] bool has_fault_of(const FaultPlan& plan, FaultPart part);

}  // namespace g3d::hal
