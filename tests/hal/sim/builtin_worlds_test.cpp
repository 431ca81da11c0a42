// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/builtin_worlds.hpp"

#include <catch2/catch.hpp>
#include <string>

#include "hal/sim/load_world.hpp"
#include "hal/sim/world_query.hpp"

using namespace g3d::hal;

TEST_CASE("every built-in world and path is good") {
  CHECK(builtin_names().size() == 5);
  for (const std::string_view name : builtin_names()) {
    CAPTURE(name);
    const auto world = load_world(std::string(name));
    const auto path = load_camera_path(std::string(name));
    if (!world.ok()) FAIL(world.error().text);
    if (!path.ok()) FAIL(path.error().text);
  }
  CHECK(builtin_world("nowhere").empty());
  CHECK(builtin_path("nowhere").empty());
}

TEST_CASE("no built-in drive comes nearer than 0.3 m to anything") {
  for (const std::string_view name : builtin_names()) {
    CAPTURE(name);
    const World world = load_world(std::string(name)).value();
    const CameraPath path = load_camera_path(std::string(name)).value();
    for (TimeNs t = path.begin_ns(); t <= path.end_ns(); t += 50'000'000) {
      const Pose pose = path.pose_at(t);
      REQUIRE(clearance_m(world, t, pose.translation_m) >= 0.3);
    }
  }
}
