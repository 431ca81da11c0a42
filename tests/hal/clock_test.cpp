// SPDX-License-Identifier: Apache-2.0
#include "hal/clock.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <thread>
#include <vector>

using namespace g3d::hal;

TEST_CASE("The real clock moves forward and sleeps at least as long as asked") {
  RealClock clock;
  const TimeNs start_ns = clock.now();
  clock.sleep_until(start_ns + 5'000'000);
  CHECK(clock.now() >= start_ns + 5'000'000);
  const TimeNs before_ns = clock.now();
  clock.sleep_until(start_ns);
  clock.sleep_until(-1);
  clock.sleep_until(std::numeric_limits<TimeNs>::min());
  CHECK(clock.now() - before_ns < 1'000'000'000);
}

TEST_CASE("The data clock stands still, and never goes backwards") {
  DataClock clock;
  CHECK(clock.now() == 0);
  clock.advance_to(100);
  clock.advance_to(50);
  CHECK(clock.now() == 100);
  clock.sleep_until(100);
  clock.close();
  clock.sleep_until(1'000);
  CHECK(clock.now() == 100);
}

TEST_CASE("Several threads advance the data clock to the latest of their times", "[threads]") {
  DataClock clock;
  std::vector<std::thread> threads;
  for (int k = 0; k < 3; ++k) {
    threads.emplace_back([&clock, k] {
      for (TimeNs t = 0; t < 5'000; ++t) clock.advance_to(3 * t + k);
    });
  }
  clock.sleep_until(3 * 4'999 + 2);
  CHECK(clock.now() == 3 * 4'999 + 2);
  for (auto& thread : threads) thread.join();
  CHECK(clock.now() == 3 * 4'999 + 2);
}

TEST_CASE("a slow clock is the real one at 100, and goes as many times slower as it is told to") {
  const RealClock real;
  const SlowClock same, slow(400), odd(333);
  const TimeNs before_ns = real.now();
  const TimeNs same_ns = same.now(), slow_ns = slow.now(), odd_ns = odd.now();
  const TimeNs after_ns = real.now();
  CHECK(same_ns >= before_ns);
  CHECK(same_ns <= after_ns);
  CHECK(slow_ns >= before_ns / 4 - 1);
  CHECK(slow_ns <= after_ns / 4);
  CHECK(odd_ns >= before_ns / 333 * 100);
  CHECK(odd_ns <= after_ns / 333 * 100 + 100);
}

TEST_CASE("who sleeps by a slow clock sleeps longer, and not too short by its own") {
  const RealClock real;
  SlowClock slow(350);
  const TimeNs begin_ns = real.now(), slow_begin_ns = slow.now();
  slow.sleep_until(slow_begin_ns + 10'000'000);
  CHECK(slow.now() >= slow_begin_ns + 10'000'000);
  CHECK(real.now() - begin_ns >= 34'990'000);
  slow.sleep_until(0);
  slow.sleep_until(-5);
}
