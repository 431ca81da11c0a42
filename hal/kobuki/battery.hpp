// SPDX-License-Identifier: Apache-2.0
// How full the battery is. Its voltage sags while the motors pull and one reading may be wrong, so that levels follow a
// mean over seconds and change back only when it is clearly better.
#pragma once

#include "hal/kobuki/feedback.hpp"

namespace g3d::hal::kobuki {

enum class BatteryLevel : std::uint8_t { healthy, low, critical };
[[nodiscard]] const char* to_string(BatteryLevel level);

enum class PowerSource : std::uint8_t { battery, dock, adapter };

struct BatteryOptions {
  double full_v = 16.5;
  double low_v = 14.0;       ///< time to go home
  double critical_v = 13.2;  ///< time to stop
  double hysteresis_v = 0.3;
  double life_s = 3.0 * 3600.0;  ///< of driving, from full to critical, as long as nothing else has been measured
};

/// One thread. The mean begins with the first reading.
class Battery {
 public:
  explicit Battery(const BatteryOptions& options = {}) : options_(options) {}
  void update(const Feedback& feedback);
  [[nodiscard]] BatteryLevel level() const { return level_; }
  /// Mean of about 5 s; 0 before the first reading.
  [[nodiscard]] double voltage_v() const { return voltage_v_; }
  /// 0 at critical, 1 at full, linear in voltage between: an estimate.
  [[nodiscard]] double charge() const;
  /// Of driving until critical: by the life that a full one has, or by what it lost since it was watched, whichever is
  /// less. Infinite before the first reading and while it is on a charger.
  [[nodiscard]] double left_s() const;
  [[nodiscard]] PowerSource source() const { return source_; }
  [[nodiscard]] bool is_charging() const { return is_charging_; }

 private:
  BatteryOptions options_;
  double voltage_v_ = 0.0;
  double watched_from_v_ = 0.0;  ///< since the first reading, or the last charge
  TimeNs watched_from_ns_ = 0;
  TimeNs now_ns_ = 0;
  BatteryLevel level_ = BatteryLevel::healthy;
  PowerSource source_ = PowerSource::battery;
  bool is_charging_ = false;
};

}  // namespace g3d::hal::kobuki
