// SPDX-License-Identifier: Apache-2.0
#include "hal/parking.hpp"

#include <catch2/catch.hpp>
#include <ctime>
#include <thread>

#include "hal/clock.hpp"
#include "hal/ring.hpp"

using namespace g3d::hal;

namespace {

TimeNs thread_cpu_ns() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<TimeNs>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

}  // namespace

TEST_CASE("Parking returns at once when ready, and false once stopped") {
  Parking parking;
  CHECK(parking.wait([] { return true; }));
  CHECK_FALSE(parking.stopped());
  parking.stop();
  CHECK(parking.stopped());
  CHECK_FALSE(parking.wait([] { return false; }));
  CHECK(parking.wait([] { return true; }));  // what is there is still taken
}

TEST_CASE("No wake is lost between two parked threads", "[threads]") {
  constexpr int kCount = 50'000;
  Ring<int> there(1);
  Ring<int> back(1);
  Parking near_side;
  Parking far_side;
  std::thread echo([&] {
    int message = 0;
    while (far_side.wait([&] { return there.try_pop(message); })) {
      if (back.try_push(message)) near_side.wake();
    }
  });
  int bad = 0;
  const RealClock clock;
  const TimeNs end_ns = clock.now() + 2'000'000'000;  // beside other work every turn may cost a time slice
  int i = 0;
  for (; i < kCount && clock.now() < end_ns; ++i) {
    if (!there.try_push(i)) ++bad;
    far_side.wake();
    int answer = -1;
    if (!near_side.wait([&] { return back.try_pop(answer); }) || answer != i) ++bad;
  }
  far_side.stop();
  echo.join();
  CHECK(bad == 0);
  CHECK(i > 100);
}

TEST_CASE("A parked thread sleeps, and stop ends it", "[threads]") {
  Parking parking;
  TimeNs cpu_ns = 0;
  bool result = true;
  std::thread waiting([&] {
    const TimeNs before_ns = thread_cpu_ns();
    result = parking.wait([] { return false; });
    cpu_ns = thread_cpu_ns() - before_ns;
  });
  RealClock clock;
  clock.sleep_until(clock.now() + 100'000'000);
  parking.stop();
  waiting.join();
  CHECK_FALSE(result);
  CHECK(cpu_ns < 50'000'000);
}
