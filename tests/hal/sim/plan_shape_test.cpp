// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/plan_shape.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace g3d::hal;

namespace {

Primitive only(const World& world) { return world.primitives().at(0); }

}  // namespace

TEST_CASE("a turned box is met at its corner and along its sides") {
  World world;
  world.add_box({1, 2, 0}, {2, 1, 0.5}, 90, {});
  const Primitive box = only(world);
  const HeightSlice slice{0.05, 0.6};
  CHECK(nearest_in_plan(box, slice, 1.2, 2.5).distance_m == 0.0);  // long side along y now
  const PlanPoint side = nearest_in_plan(box, slice, 3.0, 2.0);
  CHECK(side.distance_m == Approx(1.5));
  CHECK(side.x_m == Approx(1.5));
  CHECK(side.y_m == Approx(2.0));
  const PlanPoint corner = nearest_in_plan(box, slice, 1.8, 3.4);
  CHECK(corner.distance_m == Approx(0.5));
  CHECK(corner.x_m == Approx(1.5));
  CHECK(corner.y_m == Approx(3.0));
}

TEST_CASE("what lies above or below the slice is not met") {
  World world;
  world.add_box({0, 0, 0.7}, {1, 1, 0.1}, 0, {});
  CHECK(std::isinf(nearest_in_plan(only(world), {0.02, 0.6}, 0, 0).distance_m));
  CHECK(nearest_in_plan(only(world), {0.02, 0.75}, 0, 0).distance_m == 0.0);
  World rug;
  rug.add_box({0, 0, 0}, {1, 1, 0.015}, 0, {});
  CHECK(std::isinf(nearest_in_plan(only(rug), {0.02, 0.6}, 0, 0).distance_m));
}

TEST_CASE("round solids have the radius of their widest part within the slice") {
  World world;
  world.add_sphere({0, 0, 1.0}, 0.5, {});
  CHECK(nearest_in_plan(only(world), {0.0, 0.6}, 2, 0).distance_m == Approx(2 - 0.3));
  CHECK(nearest_in_plan(only(world), {0.0, 1.6}, 2, 0).distance_m == Approx(1.5));
  CHECK(std::isinf(nearest_in_plan(only(world), {0.0, 0.45}, 2, 0).distance_m));
  World cone;
  cone.add_cone({0, 0, 0}, 0.5, 1.0, 0.1, {});
  CHECK(nearest_in_plan(only(cone), {0.5, 2.0}, 1, 0).distance_m == Approx(1 - 0.3));
  CHECK(nearest_in_plan(only(cone), {0.0, 0.1}, 0, 1).distance_m == Approx(0.5));
  World pole;
  pole.add_cylinder({1, 1, 0}, 0.1, 1, {});
  const PlanPoint at = nearest_in_plan(only(pole), {0.05, 0.1}, 0, 1);
  CHECK(at.distance_m == Approx(0.9));
  CHECK(at.x_m == Approx(0.9));
}

TEST_CASE("the rectangle around a plan holds it") {
  World world;
  world.add_box({0, 0, 0}, {2, 1, 1}, 30, {});
  const PlanExtent extent = plan_extent(only(world));
  CHECK(extent.x_m == Approx(std::sqrt(0.75) + 0.25));
  CHECK(extent.y_m == Approx(0.5 + 0.5 * std::sqrt(0.75)));
}
