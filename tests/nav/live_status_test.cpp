// SPDX-License-Identifier: Apache-2.0
#include "nav/live_status.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <string>

using namespace g3d;
using namespace g3d::nav;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("a status says what the robot does and what limits it") {
  LiveStatus status;
  status.state = MissionState::paused;
  status.purpose = MissionState::exploring;
  status.coverage = 0.51237;
  status.path_m = 12.34567;
  status.battery_v = 14.5;
  status.battery_charge = 0.4;
  status.energy_left_s = 1234.4;
  status.safety = hal::SafetyState::stand;
  status.limited_by = hal::Condition::silent_camera;
  status.last_reason = hal::Condition::bumper;
  status.last_reason_s = 2.0;
  const std::string json = to_json(status);
  CHECK(contains(json, "\"state\": \"paused\""));
  CHECK(contains(json, "\"purpose\": \"exploring\""));
  CHECK(contains(json, "\"coverage\": 0.5124"));
  CHECK(contains(json, "\"path_m\": 12.346"));
  CHECK(contains(json, "\"left_s\": 1234"));
  CHECK(contains(json, "\"limited_by\": \"silent_camera\""));
  CHECK(contains(json, "\"last_reason\": \"bumper\""));
  CHECK(contains(json, "\"last_reason_s\": 2"));
}

TEST_CASE("what nobody knows is null") {
  LiveStatus status;
  status.energy_left_s = std::numeric_limits<double>::infinity();
  const std::string json = to_json(status);
  CHECK(contains(json, "\"coverage\": null"));
  CHECK(contains(json, "\"left_s\": null"));
  CHECK(contains(json, "\"limited_by\": \"none\""));
  CHECK(contains(json, "\"last_reason_s\": null"));
}

TEST_CASE("navigator and base are asked what they know") {
  const mapper::Grid grid{0.05F};
  const Navigator navigator(grid, {});
  hal::kobuki::BaseState base;
  base.battery_v = 15.0;
  base.verdict.reason = hal::Condition::bumper;
  base.last_reason = hal::Condition::cliff;
  base.last_reason_ns = 1'000'000'000;
  const LiveStatus status = status_of(navigator, base, {1.0, 2.0, 0.5}, 3'000'000'000);
  CHECK(status.state == MissionState::starting);
  CHECK(status.battery_v == 15.0);
  CHECK(status.limited_by == hal::Condition::bumper);
  CHECK(status.last_reason_s == Approx(2.0));
  CHECK(status.T_world_base.y_m == 2.0);
}
