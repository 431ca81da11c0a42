// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "hal/kinect/sensor_stamps.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kinect;

namespace {

constexpr TimeNs kPeriod_ns = 33'333'333;

}  // namespace

TEST_CASE("stamps follow the sensor's even clock, not the uneven arrival, once it has proven itself") {
  const int bits = GENERATE(32, 64);
  const double tick_ns = bits == 32 ? 1000.0 / 60.0 : 1000.0;
  SensorStamps stamps({tick_ns, bits, 20 * kMillisecond_ns});
  std::mt19937 random(1);
  // The 32-bit counter begins shortly before it wraps.
  double device_ns = bits == 32 ? 4294000000.0 * tick_ns : 5e9;
  TimeNs shown_ns = 1'000'000'000'000;
  TimeNs worst_ns = 0, arrived_ns = 0;
  for (int i = 0; i < 3000; ++i) {
    shown_ns += kPeriod_ns;
    device_ns += static_cast<double>(kPeriod_ns) * (1.0 + 50e-6);  // another quartz
    const TimeNs late_ns = static_cast<TimeNs>(random() % 8'000'000) + (i % 50 == 7 ? 60'000'000 : 0);
    const auto ticks = static_cast<std::uint64_t>(device_ns / tick_ns);
    // One that is late keeps those behind it waiting.
    arrived_ns = std::max(arrived_ns, shown_ns + 20 * kMillisecond_ns + late_ns);
    const TimeNs stamp_ns = stamps.update(bits == 32 ? ticks & 0xFFFFFFFFU : ticks, arrived_ns);
    if (i > 200) worst_ns = std::max(worst_ns, std::abs(stamp_ns - shown_ns));
  }
  CHECK(worst_ns < 2 * kMillisecond_ns);
  CHECK(stamps.doubtful() == 0);
}

TEST_CASE("a sensor's clock that stands, leaps or runs at another speed is not believed; stamps rise all the same") {
  const double speed = GENERATE(0.0, 0.5, 1.3, 3.0);
  SensorStamps stamps({1000.0, 64, 0});
  TimeNs last_ns = 0;
  TimeNs arrived_ns = 1'000'000'000;
  for (int i = 0; i < 500; ++i) {
    arrived_ns += kPeriod_ns;
    const auto ticks = static_cast<std::uint64_t>(1e6 + speed * 33333.333 * i + (i == 250 ? 1e12 : 0.0));
    const TimeNs stamp_ns = stamps.update(ticks, arrived_ns);
    CHECK(stamp_ns > last_ns);
    CHECK(std::abs(stamp_ns - arrived_ns) <= kMillisecond_ns);
    last_ns = stamp_ns;
  }
  CHECK(stamps.doubtful() > 0);
}
