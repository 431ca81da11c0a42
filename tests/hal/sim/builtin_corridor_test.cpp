// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>

#include "hal/sim/load_world.hpp"
#include "hal/sim/world_query.hpp"

using namespace g3d::hal;

TEST_CASE("the corridor is a closed loop of about 60 m") {
  const World world = load_world("corridor").value();
  const CameraPath path = load_camera_path("corridor").value();
  double length_m = 0.0;
  for (TimeNs t = path.begin_ns(); t < path.end_ns(); t += 100'000'000) {
    const Pose a = path.pose_at(t);
    const Pose b = path.pose_at(t + 100'000'000);
    length_m += std::hypot(b.translation_m[0] - a.translation_m[0], b.translation_m[1] - a.translation_m[1]);
    // Closed all round at every place.
    for (int k = 0; k < 12; ++k) {
      const double angle = 0.5236 * k;
      REQUIRE(cast_ray(world, t, a.translation_m, {std::cos(angle), std::sin(angle), 0.1}).t < 30.0);
    }
  }
  CHECK(length_m > 55.0);
  CHECK(length_m < 61.0);
}
