// SPDX-License-Identifier: Apache-2.0
// The only source of time. Real boards and `--rate 1` use RealClock; replay and simulation in lockstep use DataClock,
// which stands still until the data say otherwise.
#pragma once

#include <atomic>

#include "hal/messages.hpp"
#include "hal/parking.hpp"

namespace g3d::hal {

class Clock {
 public:
  virtual ~Clock() = default;
  /// Nanoseconds since the clock's epoch; never goes backwards. Any thread.
  [[nodiscard]] virtual TimeNs now() const = 0;
  /// Returns when now() >= t_ns, at once if it already is. Any thread.
  virtual void sleep_until(TimeNs t_ns) = 0;
};

/// CLOCK_MONOTONIC.
class RealClock final : public Clock {
 public:
  [[nodiscard]] TimeNs now() const override;
  void sleep_until(TimeNs t_ns) override;
};

/// CLOCK_MONOTONIC at a slower pace, for a world that an emulated machine or a busy one can keep up with: everything
/// that reads it believes that it lives in real time. At 100 it is RealClock.
class SlowClock final : public Clock {
 public:
  /// `slow_percent`: hundredths of a real second that one of its seconds takes, 100 to 10000.
  explicit SlowClock(std::uint32_t slow_percent = 100) : slow_percent_(slow_percent) {}
  [[nodiscard]] TimeNs now() const override;
  void sleep_until(TimeNs t_ns) override;
  [[nodiscard]] std::uint32_t slow_percent() const { return slow_percent_; }

 private:
  const std::uint32_t slow_percent_;
};

/// Time as the data tell it, beginning with 0.
class DataClock final : public Clock {
 public:
  [[nodiscard]] TimeNs now() const override { return now_ns_.load(std::memory_order_acquire); }
  /// Waits for advance_to or close by another thread.
  void sleep_until(TimeNs t_ns) override;
  /// Any thread. An earlier time than now() is ignored.
  void advance_to(TimeNs t_ns);
  /// No more data will come: nobody sleeps any longer.
  void close();

 private:
  std::atomic<TimeNs> now_ns_{0};
  Parking sleepers_;
};

}  // namespace g3d::hal
