// SPDX-License-Identifier: Apache-2.0
#include "nav/mission.hpp"

#include <catch2/catch.hpp>
#include <set>
#include <string_view>
#include <vector>

using namespace g3d;
using nav::Mission;
using S = nav::MissionState;
using E = nav::MissionEvent;

namespace {

const std::vector<S> kStates{S::starting, S::exploring, S::returning, S::home, S::paused, S::stopped, S::needs_help};
const std::vector<E> kEvents{E::looked_around, E::explored, E::battery_low, E::come_home, E::at_home, E::no_way_home,
                             E::more_to_see,   E::lost,     E::pause,       E::resume,    E::stop};

Mission mission_in(S state) {
  Mission m;
  if (state == S::starting) return m;
  m.apply(E::looked_around);
  if (state == S::paused) m.apply(E::pause);
  if (state == S::stopped) m.apply(E::stop);
  if (state == S::needs_help) m.apply(E::lost);
  if (state == S::returning || state == S::home) m.apply(E::explored);
  if (state == S::home) m.apply(E::at_home);
  REQUIRE(m.state() == state);
  return m;
}

}  // namespace

TEST_CASE("A mission looks around, explores, returns and is home") {
  Mission m;
  CHECK(m.state() == S::starting);
  CHECK(m.apply(E::looked_around));
  CHECK(m.state() == S::exploring);
  CHECK_FALSE(m.apply(E::at_home));  // it has not been sent home
  CHECK(m.apply(E::explored));
  CHECK(m.state() == S::returning);
  CHECK(m.is_driving());
  CHECK(m.apply(E::at_home));
  CHECK(m.is_over());
  for (const E event : kEvents) CHECK_FALSE(m.apply(event));
}

TEST_CASE("Whatever it is about, it can be paused and stopped, and resumes just that") {
  for (const S state : {S::starting, S::exploring, S::returning}) {
    for (const E hold : {E::pause, E::stop, E::lost}) {
      Mission m = mission_in(state);
      CHECK(m.apply(hold));
      CHECK_FALSE(m.is_driving());
      CHECK(m.purpose() == state);
      CHECK_FALSE(m.apply(E::explored));
      CHECK_FALSE(m.apply(E::at_home));
      CHECK(m.apply(E::resume));
      CHECK(m.state() == state);
    }
  }
}

TEST_CASE("A stop outranks a pause, and a pause does not soften a stop") {
  Mission m = mission_in(S::paused);
  CHECK(m.apply(E::stop));
  CHECK(m.state() == S::stopped);
  CHECK_FALSE(m.apply(E::pause));
  CHECK(m.apply(E::resume));
  CHECK(m.state() == S::exploring);
}

TEST_CASE("Sent home while it is held, it goes home when resumed") {
  for (const E event : {E::come_home, E::battery_low}) {
    Mission m = mission_in(S::paused);
    m.apply(event);
    CHECK(m.state() == S::paused);
    CHECK(m.apply(E::resume));
    CHECK(m.state() == S::returning);
  }
}

TEST_CASE("Without a way home it asks for help and tries again when resumed") {
  Mission m = mission_in(S::returning);
  CHECK(m.apply(E::no_way_home));
  CHECK(m.state() == S::needs_help);
  CHECK(m.apply(E::resume));
  CHECK(m.state() == S::returning);
}

TEST_CASE("Only driving states let wheels turn, and every state has a name of its own") {
  std::set<std::string_view> names;
  for (const S state : kStates) {
    names.insert(nav::name_of(state));
    const bool drives = state == S::starting || state == S::exploring || state == S::returning;
    CHECK(mission_in(state).is_driving() == drives);
    for (const E event : kEvents) {
      Mission m = mission_in(state);
      const bool changed = m.apply(event);
      CHECK(changed == (m.state() != state));
      if (!drives && m.is_driving()) CHECK(event == E::resume);  // nothing else sets it in motion
    }
  }
  CHECK(names.size() == kStates.size());
}

TEST_CASE("On the way home it explores again if teammates have found more, and in no other state") {
  Mission m = mission_in(S::returning);
  CHECK(m.apply(E::more_to_see));
  CHECK(m.state() == S::exploring);
  for (const S state : kStates) {
    if (state != S::returning) CHECK_FALSE(mission_in(state).apply(E::more_to_see));
  }
}
