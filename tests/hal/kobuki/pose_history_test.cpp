// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/pose_history.hpp"

#include <catch2/catch.hpp>
#include <type_traits>
#include <vector>

#include "tests/support/driver_bench.hpp"

using g3d::hal::PlanarPose;
using g3d::hal::TimeNs;
using g3d::hal::kobuki::PoseHistory;

namespace {

constexpr TimeNs kMs = 1'000'000;

PoseHistory straight(int poses) {
  PoseHistory history;
  for (int i = 0; i < poses; ++i) history.add(i * 20 * kMs, {0.01 * i, -0.02 * i, 0.001 * i});
  return history;
}

}  // namespace

static_assert(std::is_trivially_copyable_v<PoseHistory>);

TEST_CASE("Between two poses it is interpolated, at one it is that one") {
  const PoseHistory history = straight(20);
  CHECK(history.at(100 * kMs) == PlanarPose{0.01 * 5, -0.02 * 5, 0.001 * 5});
  const auto between = history.at(105 * kMs);
  REQUIRE(between);
  CHECK(between->x_m == Approx(0.0525));
  CHECK(between->y_m == Approx(-0.105));
  CHECK(between->heading_rad == Approx(0.00525));
}

TEST_CASE("A little beyond the newest it goes on as before; far beyond it is unknown") {
  const PoseHistory history = straight(20);
  const auto beyond = history.at(390 * kMs);
  REQUIRE(beyond);
  CHECK(beyond->x_m == Approx(0.195));
  CHECK(history.at((380 + 40) * kMs));
  CHECK_FALSE(history.at((380 + 41) * kMs));
}

TEST_CASE("Two poses of nearly the same time say nothing about the way beyond") {
  PoseHistory history;
  history.add(0, {0.0, 0, 0});
  history.add(20 * kMs, {0.01, 0, 0});
  history.add(20 * kMs + 1, {0.02, 0, 0});  // a packet that had been held up
  const auto beyond = history.at(40 * kMs + 1);
  REQUIRE(beyond);
  CHECK(beyond->x_m == Approx(0.04));
  PoseHistory burst;
  burst.add(0, {0.0, 0, 0});
  burst.add(1, {0.01, 0, 0});
  CHECK_FALSE(burst.at(20 * kMs));
}

TEST_CASE("Before the oldest it is unknown, and the oldest are forgotten") {
  CHECK_FALSE(straight(20).at(-1));
  CHECK_FALSE(PoseHistory().at(0));
  CHECK_FALSE(straight(1).at(1));
  CHECK(straight(1).at(0));
  const PoseHistory history = straight(1'000);
  CHECK(history.size() == PoseHistory::kPoses);
  CHECK_FALSE(history.at((1'000 - 65) * 20 * kMs));
  const auto oldest = history.at((1'000 - 64) * 20 * kMs);
  REQUIRE(oldest);
  CHECK(oldest->x_m == Approx(0.01 * 936));
}

TEST_CASE("The heading takes the short way over the wrap") {
  PoseHistory history;
  history.add(0, {0, 0, 3.1});
  history.add(20 * kMs, {0, 0, -3.1});
  CHECK(history.at(5 * kMs)->heading_rad == Approx(3.1 + 0.25 * 0.0831853));
  CHECK(history.at(15 * kMs)->heading_rad == Approx(-3.1 - 0.25 * 0.0831853));
  CHECK(history.at(40 * kMs)->heading_rad == Approx(-3.1 + 0.0831853));
}

TEST_CASE("In a gap nothing is known, and time does not go backwards") {
  PoseHistory history = straight(5);
  history.add(600 * kMs, {1, 0, 0});
  CHECK_FALSE(history.at(300 * kMs));
  CHECK_FALSE(history.at(610 * kMs));
  CHECK(history.at(600 * kMs));
  history.add(600 * kMs, {2, 0, 0});
  history.add(10, {3, 0, 0});
  CHECK(history.at(600 * kMs)->x_m == 1.0);
}

TEST_CASE("Packets that were held up tell of the moments in which they were sent") {
  g3d::test::DriverBench bench;
  bench.wish = {0.3, 0.0};
  bench.steps(120);
  const double before_m = bench.state().T_world_base.x_m;
  const TimeNs before_ns = bench.now_ns;
  std::vector<std::uint8_t> held_up;
  for (int i = 0; i < 5; ++i) {
    bench.now_ns += 20 * kMs;
    bench.next_packet();
    const auto frame = g3d::tests::frame_of(bench.packet);
    if (i == 4) {
      // Before the last of them, the four others; a thread that reads them one by one needs some time for each.
      for (std::size_t j = 0; j < 4; ++j) {
        bench.driver.on_bytes(std::span(held_up).subspan(j * frame.size(), frame.size()),
                              bench.now_ns - static_cast<TimeNs>(4 - j) * 1'000);
      }
      bench.driver.on_bytes(frame, bench.now_ns);
    }
    held_up.insert(held_up.end(), frame.begin(), frame.end());
  }
  bench.tick();
  const double step_m = (bench.state().T_world_base.x_m - before_m) / 5;
  CHECK(step_m == Approx(0.006).epsilon(0.05));
  for (int i = 1; i <= 6; ++i) {  // the sixth lies ahead
    const auto pose = bench.driver.poses().at(before_ns + i * 20 * kMs);
    REQUIRE(pose);
    CHECK(pose->x_m == Approx(before_m + i * step_m).margin(2e-4));
  }
}
