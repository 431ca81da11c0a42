// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/battery.hpp"

#include <algorithm>
#include <limits>

namespace g3d::hal::kobuki {
namespace {

// Less than this, or sooner, it may be the motors that pull, and the mean needs some time to follow.
constexpr double kMeasured_v = 0.3;
constexpr double kMeasured_s = 30.0;
constexpr double kNewShare = 1.0 / 256.0;  ///< of one reading in the mean: at 50 Hz, about 5 s
// Charger byte: 2 and 6 in the dock, 18 and 22 at the adapter, charged and charging.
constexpr unsigned kStateBits = 0x0F, kAdapterBit = 0x10, kCharged = 2, kCharging = 6;

}  // namespace

const char* to_string(BatteryLevel level) {
  switch (level) {
    case BatteryLevel::healthy:
      return "healthy";
    case BatteryLevel::low:
      return "low";
    case BatteryLevel::critical:
      return "critical";
  }
  return "unknown";
}

void Battery::update(const Feedback& feedback) {
  const double now_v = feedback.battery_decivolts / 10.0;
  voltage_v_ = voltage_v_ == 0.0 ? now_v : voltage_v_ + kNewShare * (now_v - voltage_v_);
  const unsigned state = feedback.charger & kStateBits;
  is_charging_ = state == kCharging;
  source_ = PowerSource::battery;
  if (state == kCharging || state == kCharged) {
    source_ = (feedback.charger & kAdapterBit) != 0 ? PowerSource::adapter : PowerSource::dock;
  }

  now_ns_ = feedback.received_ns;
  if (watched_from_v_ == 0.0 || voltage_v_ > watched_from_v_ || source_ != PowerSource::battery) {
    watched_from_v_ = voltage_v_;
    watched_from_ns_ = now_ns_;
  }

  const double margin_v = options_.hysteresis_v;
  if (voltage_v_ < options_.critical_v + (level_ == BatteryLevel::critical ? margin_v : 0.0)) {
    level_ = BatteryLevel::critical;
  } else if (voltage_v_ < options_.low_v + (level_ != BatteryLevel::healthy ? margin_v : 0.0)) {
    level_ = BatteryLevel::low;
  } else {
    level_ = BatteryLevel::healthy;
  }
}

double Battery::left_s() const {
  if (voltage_v_ == 0.0 || source_ != PowerSource::battery) return std::numeric_limits<double>::infinity();
  const double by_life_s = charge() * options_.life_s;
  const double lost_v = watched_from_v_ - voltage_v_;
  const double watched_s = static_cast<double>(now_ns_ - watched_from_ns_) * 1e-9;
  if (lost_v < kMeasured_v || watched_s < kMeasured_s) return by_life_s;
  return std::min(by_life_s, std::max(0.0, voltage_v_ - options_.critical_v) * watched_s / lost_v);
}

double Battery::charge() const {
  return std::clamp((voltage_v_ - options_.critical_v) / (options_.full_v - options_.critical_v), 0.0, 1.0);
}

}  // namespace g3d::hal::kobuki
