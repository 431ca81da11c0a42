// SPDX-License-Identifier: Apache-2.0
#include "nav/progress_watch.hpp"

#include <catch2/catch.hpp>

using namespace g3d;

namespace {

constexpr hal::TimeNs kSecond_ns = 1'000'000'000;

}  // namespace

TEST_CASE("Told to move and not moving is stuck, after a while") {
  nav::ProgressWatch watch(3.0, 100.0);
  watch.start({}, 0);
  for (int s = 0; s < 3; ++s) {
    watch.step({0.3, 0.0}, {}, s * kSecond_ns);
    CHECK_FALSE(watch.is_stuck(s * kSecond_ns));
  }
  watch.step({0.3, 0.0}, {0.02, 0, 0.05}, 3 * kSecond_ns);
  CHECK(watch.is_stuck(3 * kSecond_ns));
  watch.step({0.3, 0.0}, {0.1, 0, 0}, 4 * kSecond_ns);
  CHECK_FALSE(watch.is_stuck(4 * kSecond_ns));
}

TEST_CASE("Standing because it is told to is not, and turning is moving") {
  nav::ProgressWatch watch(3.0, 100.0);
  watch.start({}, 0);
  for (int s = 0; s < 20; ++s) watch.step({}, {}, s * kSecond_ns);
  CHECK_FALSE(watch.is_stuck(19 * kSecond_ns));
  for (int s = 20; s < 40; ++s) watch.step({0.0, 0.5}, {0, 0, 0.2 * (s - 20)}, s * kSecond_ns);
  CHECK_FALSE(watch.is_stuck(39 * kSecond_ns));
}

TEST_CASE("To and fro on one spot gets nowhere; time that it had to stand is left out") {
  nav::ProgressWatch watch(3.0, 10.0);
  watch.start({}, 0);
  for (int s = 0; s <= 10; ++s) watch.step({0.1, 0.0}, {0.2 * (s % 2), 0, 0}, s * kSecond_ns);
  CHECK(watch.is_lost(10 * kSecond_ns));
  watch.leave_out(5 * kSecond_ns);
  CHECK_FALSE(watch.is_lost(10 * kSecond_ns));
  CHECK(watch.is_lost(15 * kSecond_ns));
  watch.step({0.1, 0.0}, {1.0, 0, 0}, 15 * kSecond_ns);
  CHECK_FALSE(watch.is_lost(15 * kSecond_ns));
}
