// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <vector>

#include "hal/kinect/tilt_unit.hpp"
#include "tests/support/scripted_foot.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kinect;
using g3d::test::ScriptedFoot;
using g3d::test::ScriptedFootState;

TEST_CASE("the Kinect's foot is asked and told by the documented requests") {
  ScriptedFootState script;
  TiltUnit foot(std::make_unique<ScriptedFoot>(script));
  REQUIRE(foot.tilt_to(-7.5).ok());
  CHECK(script.target_deg == -7.5);
  REQUIRE(foot.show(Light::blinking_green).ok());
  CHECK(script.light == 4);
  const auto state = foot.state();
  REQUIRE(state.ok());
  CHECK(state.value().is_moving);
  CHECK_FALSE(state.value().knows_tilt);
  CHECK(script.requests == std::vector<std::uint8_t>{0x31, 0x06, 0x32});
  CHECK(foot.tilt_to(28.0).error().reason == Reason::out_of_range);
  CHECK(foot.tilt_to(std::nan("")).error().reason == Reason::out_of_range);
  CHECK(script.target_deg == -7.5);
  script.is_gone = true;
  CHECK(foot.tilt_to(0.0).error().reason == Reason::io_error);
  CHECK(foot.show(Light::off).error().reason == Reason::io_error);
  CHECK(foot.state().error().reason == Reason::io_error);
}

TEST_CASE("a state is ten bytes: gravity in counts, tilt in half degrees, what the motor does") {
  const std::vector<std::uint8_t> level{0, 0, 0xFF, 0x9A, 0x03, 0x33, 0x00, 0x52, 0xF6, 0};
  const auto state = parse_tilt_state(level);
  REQUIRE(state.ok());
  CHECK(state.value().acceleration_g[0] == Approx(-102 / 819.0));
  CHECK(state.value().acceleration_g[1] == Approx(1.0));
  CHECK(state.value().acceleration_g[2] == Approx(82 / 819.0));
  CHECK(state.value().tilt_deg == -5.0);
  CHECK_FALSE(state.value().is_moving);
  const auto with = [&](std::size_t at, std::uint8_t value) {
    std::vector<std::uint8_t> changed = level;
    changed[at] = value;
    return parse_tilt_state(changed);
  };
  CHECK(with(9, 1).value().is_at_stop);
  CHECK(with(9, 4).value().is_moving);
  CHECK_FALSE(with(8, 0x80).value().knows_tilt);
  CHECK(with(9, 2).error().reason == Reason::malformed);
  CHECK(with(2, 0x7F).error().reason == Reason::malformed);
  CHECK(with(8, 0x85).error().reason == Reason::malformed);
  CHECK(parse_tilt_state(std::span(level).first(9)).error().reason == Reason::truncated);
  CHECK(parse_tilt_state({}).error().reason == Reason::truncated);
}

TEST_CASE("a foot that answers in part is no foot") {
  ScriptedFootState script;
  script.answer_bytes = 6;
  TiltUnit foot(std::make_unique<ScriptedFoot>(script));
  CHECK(foot.state().error().reason == Reason::truncated);
}
