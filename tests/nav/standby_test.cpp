// SPDX-License-Identifier: Apache-2.0
#include "nav/standby.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using nav::MissionState;

namespace {

constexpr hal::TimeNs kSecond_ns = 1'000'000'000;

}  // namespace

TEST_CASE("Standing by begins and ends once, and the time that it took is told step by step") {
  nav::Standby standby(20.0, 5);
  standby.start(10 * kSecond_ns);
  CHECK(standby.step(false, 11 * kSecond_ns).stood_ns == 0);
  nav::Standby::Step step = standby.step(true, 12 * kSecond_ns);
  CHECK(step.began);
  CHECK(step.stood_ns == kSecond_ns);
  step = standby.step(true, 15 * kSecond_ns);
  CHECK_FALSE(step.began);
  CHECK(step.stood_ns == 3 * kSecond_ns);
  step = standby.step(false, 16 * kSecond_ns);
  CHECK(step.ended);
  CHECK(step.stood_ns == 0);
  CHECK_FALSE(standby.step(false, 17 * kSecond_ns).ended);
}

TEST_CASE("Who needs help tries again after a while, a few times, and as often again when somebody has come") {
  nav::Standby standby(20.0, 2);
  hal::TimeNs now = 0;
  for (int round = 0; round < 2; ++round) {
    for (int tries = 0; tries < 2; ++tries) {
      standby.call_for_help(now);
      CHECK_FALSE(standby.should_retry(MissionState::needs_help, now + 19 * kSecond_ns));
      CHECK_FALSE(standby.should_retry(MissionState::paused, now + 20 * kSecond_ns));
      now += 20 * kSecond_ns;
      CHECK(standby.should_retry(MissionState::needs_help, now));
    }
    standby.call_for_help(now);
    now += 100 * kSecond_ns;
    CHECK_FALSE(standby.should_retry(MissionState::needs_help, now));
    standby.forget_retries();
  }
}
