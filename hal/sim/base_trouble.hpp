// SPDX-License-Identifier: Apache-2.0
// What each kind of fault means for a base's odometry and for its line, as what a simulated Kobuki does wrong:
//
//                 odometry                                     line
//   off           both encoders count no longer                pulled out
//   stuck         the same packet over and over                nothing comes, commands still arrive
//   garbage       encoders and gyro angle of chance            one byte in ten is wrong, both ways
//   wrong         the left encoder counts no longer            one byte in a thousand is wrong or lost, both ways
//   slow          every tenth packet comes                     every fifth packet comes
//   delayed       packets come 150 ms late                     everything comes 150 ms late, both ways
//   intermittent  off for one second of two                    off for 0.3 s of each second
#pragma once

#include "hal/sim/fault_plan.hpp"
#include "hal/sim/sim_kobuki.hpp"

namespace g3d::hal {

struct BaseTrouble {
  KobukiFaults faults;
  LineNoise to_host, to_base;
  bool operator==(const BaseTrouble&) const = default;
};

/// `usual`: the base's own noise, where no fault has another. The plan's other parts do not count.
[[nodiscard]] BaseTrouble base_trouble_at(const FaultPlan& plan, TimeNs now_ns, const SimKobukiOptions& usual);

}  // namespace g3d::hal
