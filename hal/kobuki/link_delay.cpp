// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/link_delay.hpp"

#include <algorithm>
#include <cstdlib>

namespace g3d::hal::kobuki {
namespace {

// The two quartzes differ; by less than this, or the fastest packet of an hour ago would make all later ones old.
constexpr TimeNs kMaxDrift_ppm = 500;
constexpr TimeNs kRestart_ns = 2'000 * kMillisecond_ns;  // clocks that disagree by more: the base began anew

}  // namespace

TimeNs LinkDelay::update(const Feedback& feedback) {
  const TimeNs received_step_ns = feedback.received_ns - last_received_ns_;
  const TimeNs base_step_ns = static_cast<std::uint16_t>(feedback.timestamp_ms - last_stamp_ms_) * kMillisecond_ns;
  const bool restarted = !started_ || std::abs(received_step_ns - base_step_ns) > kRestart_ns;
  last_stamp_ms_ = feedback.timestamp_ms;
  last_received_ns_ = feedback.received_ns;
  if (restarted) {
    started_ = true;
    base_time_ns_ = 0;
    fastest_ns_ = feedback.received_ns;
    return 0;
  }
  base_time_ns_ += base_step_ns;
  fastest_ns_ += std::max<TimeNs>(received_step_ns, 0) / 1'000'000 * kMaxDrift_ppm;
  const TimeNs offset_ns = feedback.received_ns - base_time_ns_;
  fastest_ns_ = std::min(fastest_ns_, offset_ns);
  return offset_ns - fastest_ns_;
}

}  // namespace g3d::hal::kobuki
