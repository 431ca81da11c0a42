// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/restart_policy.hpp"

#include <algorithm>

namespace g3d::hal::boot {

RestartPolicy::Decision RestartPolicy::on_end(const ProcessEnd& end, TimeNs ran_ns, bool is_on_trial) {
  if (end.is_good() && when_done_ == WhenDone::stay) return {NextStep::stay, 0};
  if (end.is_good() && when_done_ == WhenDone::power_off) return {NextStep::power_off, 0};
  if (ran_ns >= kForget_ns) ends_ = 0;
  if (end.is_good()) return {NextStep::start_again, kFirstWait_ns};
  ++ends_;
  if (is_on_trial && ends_ >= kMostEndsOnTrial) return {NextStep::reboot, 0};
  TimeNs wait_ns = kFirstWait_ns;
  for (int i = 1; i < ends_ && wait_ns < kLongestWait_ns; ++i) wait_ns *= 2;
  return {NextStep::start_again, std::min(wait_ns, kLongestWait_ns)};
}

}  // namespace g3d::hal::boot
