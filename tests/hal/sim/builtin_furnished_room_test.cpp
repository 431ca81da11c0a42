// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>

#include "hal/sim/load_world.hpp"
#include "hal/sim/world_query.hpp"

using namespace g3d::hal;

TEST_CASE("the furnished room is a closed 10 x 10 x 2.5 m room with thin poles, stairs and dark things") {
  const World world = load_world("furnished_room").value();
  CHECK(world.primitives().size() > 150);
  const double far = cast_ray(world, 0, {2.5, 0.3, 2.4}, {-1, 0, 0}).t;
  CHECK(far == Approx(7.5));
  CHECK(cast_ray(world, 0, {2.5, 0.0, 2.4}, {0, 0, 1}).t == Approx(0.1));
  CHECK(cast_ray(world, 0, {2.5, 0.0, 2.4}, {0, 0, -1}).t == Approx(2.4));
  std::size_t dark = 0;
  std::size_t thin = 0;
  for (const Primitive& p : world.primitives()) {
    dark += p.material.dark ? 1 : 0;
    thin += p.shape == Shape::cylinder && p.radius_low_m <= 0.015F && p.half_m[2] > 0.5F ? 1 : 0;
  }
  CHECK(dark >= 2);
  CHECK(thin >= 5);
}

TEST_CASE("the drive lasts a minute at robot height and ends where it began") {
  const CameraPath path = load_camera_path("furnished_room").value();
  CHECK(path.end_ns() - path.begin_ns() == 60'000'000'000);
  const Pose first = path.pose_at(path.begin_ns());
  const Pose last = path.pose_at(path.end_ns());
  for (std::size_t k = 0; k < 3; ++k) CHECK(first.translation_m[k] == Approx(last.translation_m[k]).margin(0.01));
  double fastest_mps = 0.0;
  for (TimeNs t = path.begin_ns(); t < path.end_ns(); t += 100'000'000) {
    const Pose a = path.pose_at(t);
    const Pose b = path.pose_at(t + 100'000'000);
    CHECK(a.translation_m[2] == Approx(0.5));
    fastest_mps = std::max(
        fastest_mps, 10 * std::hypot(b.translation_m[0] - a.translation_m[0], b.translation_m[1] - a.translation_m[1]));
  }
  CHECK(fastest_mps < 1.0);
}
