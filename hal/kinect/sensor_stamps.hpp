// SPDX-License-Identifier: Apache-2.0
// When an image was taken, in the host's time. The sensor stamps images by a clock of its own, evenly but from an
// unknown beginning; the host sees when they arrive, unevenly. The image that came fastest says how far apart the two
// clocks are. Where the sensor's stamps make no sense (an image that is not later, a clock that runs at another speed
// than it should), and during the first two seconds, arrival is all there is; the former is counted.
#pragma once

#include <cstdint>

#include "hal/kinect/sensor_link.hpp"

namespace g3d::hal::kinect {

struct SensorStampOptions {
  double tick_ns = 1000.0;
  int tick_bits = 64;     ///< 1 to 64
  TimeNs latency_ns = 0;  ///< from the moment that the image shows until the fastest image has arrived
};

/// One thread. Allocates nothing.
class SensorStamps {
 public:
  explicit SensorStamps(const SensorStampOptions& options) : options_(options) {}
  /// Rising from call to call. `arrived_ns` must not fall.
  [[nodiscard]] TimeNs update(std::uint64_t device_ticks, TimeNs arrived_ns);
  /// How often the sensor's clock made no sense.
  [[nodiscard]] std::uint64_t doubtful() const { return doubtful_; }

 private:
  [[nodiscard]] TimeNs begin_anew(std::uint64_t device_ticks, TimeNs arrived_ns);
  [[nodiscard]] TimeNs rising(TimeNs stamp_ns);

  SensorStampOptions options_;
  bool started_ = false;
  std::uint64_t last_ticks_ = 0;
  TimeNs last_arrived_ns_ = 0;
  double device_ns_ = 0.0;   // of the sensor's clock, unwrapped, since begin_anew
  double fastest_ns_ = 0.0;  // smallest arrived - device
  bool is_believed_ = false;
  double trial_device_ns_ = 0.0, trial_host_ns_ = 0.0;
  bool has_stamp_ = false;
  TimeNs last_stamp_ns_ = 0;
  std::uint64_t doubtful_ = 0;
};

}  // namespace g3d::hal::kinect
