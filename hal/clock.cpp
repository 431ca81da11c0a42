// SPDX-License-Identifier: Apache-2.0
#include "hal/clock.hpp"

#include <cerrno>
#include <ctime>

namespace g3d::hal {
namespace {

constexpr TimeNs kNsPerSecond = 1'000'000'000;

}  // namespace

TimeNs RealClock::now() const {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<TimeNs>(t.tv_sec) * kNsPerSecond + t.tv_nsec;
}

void RealClock::sleep_until(TimeNs t_ns) {
  if (t_ns <= 0) return;
  timespec t{};
  t.tv_sec = static_cast<std::time_t>(t_ns / kNsPerSecond);
  t.tv_nsec = static_cast<long>(t_ns % kNsPerSecond);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

// In parts, as nanoseconds since the machine began times a hundred may not fit.
TimeNs SlowClock::now() const {
  const TimeNs real_ns = RealClock().now();
  const TimeNs slow = slow_percent_;
  return real_ns / slow * 100 + real_ns % slow * 100 / slow;
}

void SlowClock::sleep_until(TimeNs t_ns) {
  if (t_ns <= 0) return;
  const TimeNs slow = slow_percent_;
  // Rounded up: it must not be earlier then by our own reckoning.
  RealClock().sleep_until(t_ns / 100 * slow + (t_ns % 100 * slow + 99) / 100);
}

void DataClock::sleep_until(TimeNs t_ns) {
  (void)sleepers_.wait([&] { return now() >= t_ns; });  // false: closed, and nothing is left to wait for
}

void DataClock::advance_to(TimeNs t_ns) {
  TimeNs now_ns = now_ns_.load(std::memory_order_relaxed);
  while (now_ns < t_ns &&
         !now_ns_.compare_exchange_weak(now_ns, t_ns, std::memory_order_release, std::memory_order_relaxed)) {
  }
  sleepers_.wake();
}

void DataClock::close() { sleepers_.stop(); }

}  // namespace g3d::hal
