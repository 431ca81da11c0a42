// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/link_delay.hpp"

#include <catch2/catch.hpp>

using namespace g3d::hal;
using namespace g3d::hal::kobuki;

namespace {

constexpr TimeNs kMs = 1'000'000;

// Packets by a base whose clock is off by some parts in a million, and a line that delays.
struct Line {
  LinkDelay delay;
  TimeNs base_ms = 60'000;  // wraps soon
  TimeNs true_ns = 5'000'000 * kMs;
  TimeNs ppm = 0;

  TimeNs packet(TimeNs delay_ms) {
    base_ms += 20;
    true_ns += 20 * kMs + 20 * ppm;
    Feedback feedback;
    feedback.timestamp_ms = static_cast<std::uint16_t>(base_ms);
    feedback.received_ns = true_ns + delay_ms * kMs;
    return delay.update(feedback);
  }
};

}  // namespace

TEST_CASE("A steady line has no delay to speak of") {
  Line line;
  for (int i = 0; i < 10'000; ++i) REQUIRE(line.packet(7) < kMs / 10);
}

TEST_CASE("What comes later than the fastest is late by so much") {
  Line line;
  for (int i = 0; i < 100; ++i) (void)line.packet(7);
  CHECK(line.packet(7 + 16) == Approx(16e6).margin(3e5));
  CHECK(line.packet(7 + 150) == Approx(150e6).margin(3e5));
  CHECK(line.packet(7) < kMs / 10);
}

TEST_CASE("A delay that creeps up is seen") {
  Line line;
  TimeNs seen_ns = 0;
  for (int i = 0; i < 1'000; ++i) seen_ns = line.packet(7 + i / 5);  // 10 ms in each second
  CHECK(seen_ns > 180 * kMs);
}

TEST_CASE("Clocks that drift apart are no delay") {
  for (const TimeNs ppm : {-200, 200, 400}) {
    Line line;
    line.ppm = ppm;
    for (int i = 0; i < 200'000; ++i) REQUIRE(line.packet(7) < kMs);  // more than an hour
  }
}

TEST_CASE("Lost packets are no delay, and a restarted base begins anew") {
  Line line;
  for (int i = 0; i < 10; ++i) (void)line.packet(7);
  line.base_ms += 400;
  line.true_ns += 400 * kMs;
  CHECK(line.packet(7) < kMs);
  line.base_ms = 0;
  line.true_ns += 9'000 * kMs;
  CHECK(line.packet(7) == 0);
  CHECK(line.packet(27) == Approx(20e6).margin(3e5));
}
