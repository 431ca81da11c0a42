// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/sensor_stamps.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::hal::kinect {
namespace {

// The two quartzes differ; by less than this, or the fastest image of an hour ago would make all later ones old.
constexpr double kMaxDrift = 500e-6;
// An image that comes later than this after its stamp's turn is late beyond belief: the clocks are compared anew.
constexpr double kRestart_ns = 500e6;
// For so long the two clocks are compared before the sensor's is believed, and again and again afterwards.
constexpr double kTrial_ns = 2e9;
constexpr double kMaxRateError = 0.05;

}  // namespace

TimeNs SensorStamps::rising(TimeNs stamp_ns) {
  if (has_stamp_) stamp_ns = std::max(stamp_ns, last_stamp_ns_ + 1);
  has_stamp_ = true;
  last_stamp_ns_ = stamp_ns;
  return stamp_ns;
}

TimeNs SensorStamps::begin_anew(std::uint64_t device_ticks, TimeNs arrived_ns) {
  if (started_) ++doubtful_;
  started_ = true;
  last_ticks_ = device_ticks;
  last_arrived_ns_ = arrived_ns;
  device_ns_ = 0.0;
  fastest_ns_ = static_cast<double>(arrived_ns);
  is_believed_ = false;
  trial_device_ns_ = trial_host_ns_ = 0.0;
  return rising(arrived_ns - options_.latency_ns);
}

TimeNs SensorStamps::update(std::uint64_t device_ticks, TimeNs arrived_ns) {
  if (!started_) return begin_anew(device_ticks, arrived_ns);
  const std::uint64_t mask =
      options_.tick_bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << options_.tick_bits) - 1;
  const double device_step_ns = static_cast<double>((device_ticks - last_ticks_) & mask) * options_.tick_ns;
  const double host_step_ns = static_cast<double>(arrived_ns - last_arrived_ns_);
  // A clock that went back shows as a step of half its range and more.
  if (!(device_step_ns > 0.0) || std::abs(device_step_ns - host_step_ns) > kRestart_ns) {
    return begin_anew(device_ticks, arrived_ns);
  }
  last_ticks_ = device_ticks;
  last_arrived_ns_ = arrived_ns;
  device_ns_ += device_step_ns;
  fastest_ns_ += std::max(host_step_ns, 0.0) * kMaxDrift;
  const double offset_ns = static_cast<double>(arrived_ns) - device_ns_;
  fastest_ns_ = std::min(fastest_ns_, offset_ns);
  if (offset_ns - fastest_ns_ > kRestart_ns) return begin_anew(device_ticks, arrived_ns);
  trial_device_ns_ += device_step_ns;
  trial_host_ns_ += host_step_ns;
  if (trial_host_ns_ >= kTrial_ns) {
    is_believed_ = std::abs(trial_device_ns_ / trial_host_ns_ - 1.0) <= kMaxRateError;
    if (!is_believed_) ++doubtful_;
    trial_device_ns_ = trial_host_ns_ = 0.0;
  }
  const TimeNs seen_ns = is_believed_ ? static_cast<TimeNs>(device_ns_ + fastest_ns_) : arrived_ns;
  return rising(seen_ns - options_.latency_ns);
}

}  // namespace g3d::hal::kinect
