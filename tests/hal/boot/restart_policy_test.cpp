// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/restart_policy.hpp"

#include <catch2/catch.hpp>

using namespace g3d::hal;
using namespace g3d::hal::boot;

namespace {
constexpr ProcessEnd kCrash{0, 11}, kFailure{1, 0}, kGood{0, 0};
constexpr TimeNs kShort_ns = 1'000'000'000;
}  // namespace

TEST_CASE("a robot that dies is started again, after twice as long each time, up to a bound", "[boot]") {
  RestartPolicy policy(WhenDone::stay);
  TimeNs expected_ns = RestartPolicy::kFirstWait_ns;
  for (int i = 0; i < 100; ++i) {
    const auto next = policy.on_end(i % 2 == 0 ? kCrash : kFailure, kShort_ns, false);
    REQUIRE(next.step == NextStep::start_again);
    REQUIRE(next.wait_ns == expected_ns);
    expected_ns = std::min(2 * expected_ns, RestartPolicy::kLongestWait_ns);
  }
  CHECK(policy.ends() == 100);
  // One that has run for a minute begins with a clean sheet.
  CHECK(policy.on_end(kCrash, RestartPolicy::kForget_ns, false).wait_ns == RestartPolicy::kFirstWait_ns);
  CHECK(policy.ends() == 1);
}

TEST_CASE("a system on trial whose robot keeps dying is left for the other one", "[boot]") {
  RestartPolicy policy(WhenDone::stay);
  for (int i = 1; i < RestartPolicy::kMostEndsOnTrial; ++i) {
    CHECK(policy.on_end(kCrash, kShort_ns, true).step == NextStep::start_again);
  }
  CHECK(policy.on_end(kCrash, kShort_ns, true).step == NextStep::reboot);
}

TEST_CASE("a robot that has ended well does what it was told to do then", "[boot]") {
  CHECK(RestartPolicy(WhenDone::stay).on_end(kGood, kShort_ns, true).step == NextStep::stay);
  CHECK(RestartPolicy(WhenDone::power_off).on_end(kGood, kShort_ns, false).step == NextStep::power_off);
  RestartPolicy again(WhenDone::again);
  for (int i = 0; i < 10; ++i) {
    const auto next = again.on_end(kGood, kShort_ns, true);
    CHECK(next.step == NextStep::start_again);
    CHECK(next.wait_ns == RestartPolicy::kFirstWait_ns);
  }
  // Bad ends are never taken for good ones.
  CHECK(RestartPolicy(WhenDone::power_off).on_end(kFailure, kShort_ns, false).step == NextStep::start_again);
}
