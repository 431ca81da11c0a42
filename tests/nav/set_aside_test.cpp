// SPDX-License-Identifier: Apache-2.0
#include "nav/set_aside.hpp"

#include <catch2/catch.hpp>

using namespace g3d::nav;

namespace {
constexpr g3d::hal::TimeNs kSecond = 1'000'000'000;
}

TEST_CASE("what was tried in vain rests, longer each time, and is given up at last") {
  SetAside aside;
  aside.reset(10, 3, 30.0);
  aside.target_failed(4, SetAside::Cause::fruitless, 0);
  CHECK(aside.ignored()[4] != 0);
  CHECK(aside.ignored()[3] == 0);
  aside.expire(29 * kSecond);
  CHECK(aside.ignored()[4] != 0);
  aside.expire(30 * kSecond);
  CHECK(aside.ignored()[4] == 0);
  aside.target_failed(4, SetAside::Cause::blocked, 100 * kSecond);
  CHECK(aside.was_blocked(4));
  aside.expire(159 * kSecond);
  CHECK(aside.ignored()[4] != 0);
  aside.expire(160 * kSecond);
  CHECK(aside.ignored()[4] == 0);
  CHECK_FALSE(aside.is_given_up(4));
  aside.target_failed(4, SetAside::Cause::fruitless, 200 * kSecond);
  CHECK(aside.is_given_up(4));
  CHECK_FALSE(aside.was_blocked(4));
  aside.expire(100000 * kSecond);
  CHECK(aside.ignored()[4] != 0);
}

TEST_CASE("failing while it rests does not count twice, and rests can be ended at once") {
  SetAside aside;
  aside.reset(10, 2, 30.0);
  CHECK_FALSE(aside.wake_all());
  aside.target_failed(1, SetAside::Cause::fruitless, 0);
  aside.target_failed(1, SetAside::Cause::fruitless, 0);
  CHECK_FALSE(aside.is_given_up(1));
  aside.exclude(2);
  CHECK(aside.wake_all());
  CHECK(aside.ignored()[1] == 0);
  CHECK(aside.is_excluded(2));
  CHECK(aside.ignored()[2] != 0);
}

TEST_CASE("what was blocked is forgiven, what was looked at in vain is not") {
  SetAside aside;
  aside.reset(10, 2, 30.0);
  aside.exclude(5);
  for (const std::uint32_t target : {1U, 2U, 5U}) aside.target_failed(target, SetAside::Cause::blocked, 0);
  aside.target_failed(3, SetAside::Cause::fruitless, 0, 2);
  aside.target_failed(4, SetAside::Cause::fruitless, 0);
  aside.expire(30 * kSecond);
  aside.target_failed(2, SetAside::Cause::blocked, 40 * kSecond);
  aside.target_failed(4, SetAside::Cause::fruitless, 40 * kSecond);
  aside.place_failed({50, 50}, 40 * kSecond);
  REQUIRE(aside.is_given_up(2));
  aside.target_failed(1, SetAside::Cause::blocked, 50 * kSecond);
  aside.forgive_blocked();
  for (const std::uint32_t target : {1U, 2U}) {
    CHECK(aside.ignored()[target] == 0);
    CHECK_FALSE(aside.is_given_up(target));
  }
  CHECK(aside.is_given_up(3));
  CHECK(aside.is_given_up(4));
  CHECK(aside.is_excluded(5));
  CHECK_FALSE(aside.is_place_resting({50, 50}, 1));
  aside.target_failed(2, SetAside::Cause::blocked, 60 * kSecond);  // counts as the first time
  CHECK_FALSE(aside.is_given_up(2));
}

TEST_CASE("places rest with those near them") {
  SetAside aside;
  aside.reset(1, 3, 10.0);
  aside.place_failed({50, 50}, 0);
  CHECK(aside.is_place_resting({54, 47}, 5));
  CHECK_FALSE(aside.is_place_resting({57, 50}, 5));
  aside.expire(10 * kSecond);
  CHECK_FALSE(aside.is_place_resting({50, 50}, 5));
  aside.place_failed({50, 50}, 20 * kSecond);
  aside.expire(39 * kSecond);
  CHECK(aside.is_place_resting({50, 50}, 5));
  aside.expire(40 * kSecond);
  CHECK_FALSE(aside.is_place_resting({50, 50}, 5));
  for (int i = 0; i < 500; ++i) aside.place_failed({10 * i, 0}, i * kSecond);
  CHECK(aside.is_place_resting({4990, 0}, 1));
}

TEST_CASE("claims of teammates hide targets and take nothing else with them when they go") {
  SetAside aside;
  aside.reset(8, 3, 10.0);
  CHECK_FALSE(aside.has_claims());
  CHECK_FALSE(aside.forget_claims());
  aside.exclude(1);
  aside.claim(1);
  aside.claim(2);
  aside.claim(2);
  aside.claim(3);
  aside.unclaim(3);
  CHECK(aside.ignored()[2] != 0);
  CHECK(aside.ignored()[3] == 0);
  aside.target_failed(2, SetAside::Cause::blocked, 0);
  CHECK(aside.is_claimed(2));
  aside.forgive_blocked();
  CHECK(aside.is_claimed(2));
  CHECK_FALSE(aside.wake_all());
  CHECK(aside.ignored()[2] != 0);  // what others claim is not woken
  CHECK(aside.forget_claims());
  CHECK_FALSE(aside.has_claims());
  CHECK(aside.ignored()[2] == 0);
  CHECK(aside.is_excluded(1));
}
