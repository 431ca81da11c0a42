// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>

#include "hal/kinect/levelling.hpp"
#include "tests/support/scripted_foot.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kinect;
using g3d::test::LeapingClock;
using g3d::test::ScriptedFoot;
using g3d::test::ScriptedFootState;

namespace {

Result<Levelled> level_by(ScriptedFootState& script, const Calibration& calibration = {}, double target_deg = 0.0) {
  TiltUnit foot(std::make_unique<ScriptedFoot>(script));
  LeapingClock clock;
  LevellingOptions options;
  options.target_deg = target_deg;
  return level_camera(foot, clock, calibration, options);
}

}  // namespace

TEST_CASE("the camera is turned level, and how it stands then is measured by gravity") {
  ScriptedFootState script;
  script.roll_deg = 2.5;
  script.axis_error_deg = 1.0;
  const auto levelled = level_by(script);
  REQUIRE(levelled.ok());
  CHECK(script.head_deg == 0.0);
  REQUIRE(levelled.value().attitude.has_value());
  CHECK(levelled.value().attitude->elevation_deg == Approx(1.0).margin(0.1));
  CHECK(levelled.value().attitude->roll_deg == Approx(2.5).margin(0.1));
  CHECK_THAT(levelled.value().note, Catch::Contains("levelled"));
  Calibration calibration;
  calibration.zero_z_g = 0.0175;  // sin 1 degree
  CHECK(level_by(script, calibration, -10.0).value().attitude->elevation_deg == Approx(-10.0).margin(0.15));
}

TEST_CASE("where motor and accelerometer disagree neither is believed; the calibration can say which way z goes") {
  ScriptedFootState script;
  script.z_sign = -1.0;
  const auto levelled = level_by(script, {}, -10.0);
  REQUIRE(levelled.ok());
  CHECK_FALSE(levelled.value().attitude.has_value());
  CHECK_THAT(levelled.value().note, Catch::Contains("z_forward"));
  Calibration calibration;
  calibration.z_forward = -1.0;
  CHECK(level_by(script, calibration, -10.0).value().attitude->elevation_deg == Approx(-10.0).margin(0.1));
}

TEST_CASE("what is not at rest is not measured") {
  ScriptedFootState script;
  SECTION("somebody carries the robot") { script.noise_g = 0.2; }
  SECTION("it falls") { script.is_free_fall = true; }
  SECTION("the motor never arrives") { script.step_deg = 0.01; }
  const auto levelled = level_by(script);
  REQUIRE(levelled.ok());
  CHECK_FALSE(levelled.value().attitude.has_value());
  CHECK_FALSE(levelled.value().note.empty());
}

TEST_CASE("a motor at its stop is measured where it is; one that is gone is an error") {
  ScriptedFootState script;
  script.stop_deg = 8.0;
  script.head_deg = 5.0;
  const auto levelled = level_by(script, {}, 12.0);
  REQUIRE(levelled.ok());
  CHECK(levelled.value().attitude->elevation_deg == Approx(8.0).margin(0.1));
  script.is_gone = true;
  CHECK(level_by(script).error().reason == Reason::io_error);
}
