// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/world_query.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

using namespace g3d::hal;

namespace {

double depth_of(const World& world, std::array<double, 3> o, std::array<double, 3> d) {
  return cast_ray(world, 0, o, d).t;
}

}  // namespace

TEST_CASE("rays meet each kind of solid where school geometry says") {
  World box;
  box.add_box({3, 0, 0}, {2, 1, 1}, 0, Material{});
  CHECK(depth_of(box, {0, 0, 0.5}, {1, 0, 0}) == Approx(2.0));
  CHECK(depth_of(box, {0, 0, 0.5}, {2, 0, 0}) == Approx(1.0));
  CHECK(std::isinf(depth_of(box, {0, 0.6, 0.5}, {1, 0, 0})));
  CHECK(std::isinf(depth_of(box, {0, 0, 0.5}, {-1, 0, 0})));
  CHECK(depth_of(box, {3, 0, 0.5}, {1, 0, 0}) == 0.0);

  World turned;
  turned.add_box({3, 0, 0}, {1, 1, 1}, 45, Material{});
  CHECK(depth_of(turned, {0, 0, 0.5}, {1, 0, 0}) == Approx(3 - std::sqrt(0.5)));

  World ball;
  ball.add_sphere({5, 0, 1}, 0.5, Material{});
  CHECK(depth_of(ball, {0, 0, 1}, {1, 0, 0}) == Approx(4.5));
  CHECK(depth_of(ball, {0, 0.3, 1}, {1, 0, 0}) == Approx(4.6));

  World post;
  post.add_cylinder({5, 0, 0}, 0.5, 2, Material{});
  CHECK(depth_of(post, {0, 0.3, 1}, {1, 0, 0}) == Approx(4.6));
  CHECK(std::isinf(depth_of(post, {0, 0, 2.1}, {1, 0, 0})));
  CHECK(depth_of(post, {5, 0.2, 4}, {0, 0, -1}) == Approx(2.0));

  World cone;
  cone.add_cone({5, 0, 0}, 1.0, 2.0, 0.0, Material{});
  CHECK(depth_of(cone, {0, 0, 1}, {1, 0, 0}) == Approx(4.5));
  CHECK(depth_of(cone, {5, 0.5, 4}, {0, 0, -1}) == Approx(3.0));
  World funnel;
  funnel.add_cone({5, 0, 0}, 0.5, 1.0, 1.0, Material{});
  CHECK(depth_of(funnel, {0, 0, 0.5}, {1, 0, 0}) == Approx(4.25));
  CHECK(depth_of(funnel, {5.9, 0, -1}, {0, 0, 1}) == Approx(1.8));
}

TEST_CASE("points just before the hit are air, just behind it matter") {
  World world;
  world.add_box({2, 1, 0.2}, {0.6, 0.9, 0.7}, 33, Material{});
  world.add_sphere({2, -1, 1}, 0.6, Material{});
  world.add_cylinder({-2, 1, 0}, 0.3, 1.5, Material{});
  world.add_cone({-2, -1, 0}, 0.7, 1.6, 0.2, Material{});
  world.add_cone({0, 2, 0}, 0.2, 1.2, 0.8, Material{});
  std::mt19937 rng(5);
  std::normal_distribution<double> normal;
  int hits = 0;
  for (int n = 0; n < 5000; ++n) {
    const std::array<double, 3> o = {0.3 * normal(rng), 0.3 * normal(rng), 0.8 + 0.3 * normal(rng)};
    const std::array<double, 3> d = {normal(rng), normal(rng), 0.5 * normal(rng)};
    const RayHit hit = cast_ray(world, 0, o, d);
    if (!std::isfinite(hit.t) || hit.t == 0.0) continue;
    ++hits;
    const auto at = [&](double t) { return std::array<double, 3>{o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]}; };
    REQUIRE_FALSE(is_solid(world, 0, at(hit.t - 1e-4)));
    REQUIRE(clearance_m(world, 0, at(hit.t + 1e-6)) < 1e-4);
    // A ray that only grazes an edge is out again after less than this.
    if (is_solid(world, 0, at(hit.t + 1e-3))) REQUIRE(is_solid(world, 0, at(hit.t + 1e-5)));
  }
  CHECK(hits > 500);
}

TEST_CASE("clearance is the distance to the nearest side") {
  World world;
  world.add_box({2, 0, 0}, {1, 1, 1}, 0, Material{});
  CHECK(clearance_m(world, 0, {0, 0, 0.5}) == Approx(1.5));
  CHECK(clearance_m(world, 0, {1.2, 0.9, 0.5}) == Approx(0.5));
  CHECK(clearance_m(world, 0, {2, 0, 0.5}) == 0.0);
  World post;
  post.add_cylinder({0, 0, 0}, 0.5, 1, Material{});
  CHECK(clearance_m(post, 0, {0.8, 0, 1.4}) == Approx(0.5));
}

TEST_CASE("glass is passed unless asked for") {
  World world;
  Material glass;
  glass.glass = true;
  world.add_box({1, 0, 0}, {0.1, 1, 1}, 0, glass);
  world.add_box({3, 0, 0}, {0.2, 1, 1}, 0, Material{});
  CHECK(cast_ray(world, 0, {0, 0, 0.5}, {1, 0, 0}).t == Approx(2.9));
  CHECK(cast_ray(world, 0, {0, 0, 0.5}, {1, 0, 0}, true).t == Approx(0.95));
}
