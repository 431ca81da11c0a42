// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/builtin_worlds.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "hal/sim/load_world.hpp"
#include "hal/sim/reach.hpp"
#include "hal/sim/world_query.hpp"

using namespace g3d::hal;

TEST_CASE("every built-in world and path is good") {
  CHECK(builtin_names().size() == 17);
  for (const std::string_view name : builtin_names()) {
    CAPTURE(name);
    const auto world = load_world(std::string(name));
    if (!world.ok()) FAIL(world.error().text);
    if (builtin_path(name).empty()) continue;
    const auto path = load_camera_path(std::string(name));
    if (!path.ok()) FAIL(path.error().text);
  }
  CHECK(builtin_world("nowhere").empty());
  CHECK(builtin_path("nowhere").empty());
}

TEST_CASE("no built-in drive comes nearer than 0.3 m to anything") {
  for (const std::string_view name : builtin_names()) {
    if (builtin_path(name).empty()) continue;
    CAPTURE(name);
    const World world = load_world(std::string(name)).value();
    const CameraPath path = load_camera_path(std::string(name)).value();
    for (TimeNs t = path.begin_ns(); t <= path.end_ns(); t += 50'000'000) {
      const Pose pose = path.pose_at(t);
      REQUIRE(clearance_m(world, t, pose.translation_m) >= 0.3);
    }
  }
}

TEST_CASE("worlds to explore have starts from which the same floor is reached, room to see, and are closed", "[slow]") {
  CHECK(exploration_names().size() >= 8);
  for (const std::string_view name : exploration_names()) {
    CAPTURE(name);
    const World world = load_world(std::string(name)).value();
    REQUIRE(world.starts().size() >= 2);
    const FloorContact floor(world);
    const PlanFrame frame = plan_frame(world).value();
    const auto reached = reachable_cells(floor, frame, std::span(world.starts()).first(1));
    CHECK(std::count(reached.begin(), reached.end(), 1) * frame.cell_m * frame.cell_m > 30.0);
    for (const PlanarPose& start : world.starts()) {
      CAPTURE(start.x_m, start.y_m);
      CHECK(reached[frame.index(frame.column_of(start.x_m), frame.row_of(start.y_m))] == 1);
      // No ray at any height below the ceiling leaves.
      for (int i = 0; i < 3600; ++i) {
        const double angle = i * 0.1 * 3.14159265358979 / 180.0;
        REQUIRE(cast_ray(world, 0, {start.x_m, start.y_m, 0.1 + 2.0 * i / 3600}, {std::cos(angle), std::sin(angle), 0},
                         true)
                    .t < 30.0);
      }
    }
    // Nothing is so low that a 5 cm map cannot tell it from the floor and so high that wheels stop at it.
    for (const Primitive& p : world.primitives()) {
      if (p.centre_m[2] - p.half_m[2] > 0.05F) continue;
      const double top_m = upper_side_m(p);
      CHECK((top_m <= kClimb_m || top_m > 0.07));
    }
  }
}
