// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/battery.hpp"

#include <algorithm>

namespace g3d::hal::kobuki {
namespace {

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

  const double margin_v = options_.hysteresis_v;
  if (voltage_v_ < options_.critical_v + (level_ == BatteryLevel::critical ? margin_v : 0.0)) {
    level_ = BatteryLevel::critical;
  } else if (voltage_v_ < options_.low_v + (level_ != BatteryLevel::healthy ? margin_v : 0.0)) {
    level_ = BatteryLevel::low;
  } else {
    level_ = BatteryLevel::healthy;
  }
}

double Battery::charge() const {
  return std::clamp((voltage_v_ - options_.critical_v) / (options_.full_v - options_.critical_v), 0.0, 1.0);
}

}  // namespace g3d::hal::kobuki
