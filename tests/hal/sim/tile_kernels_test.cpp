// SPDX-License-Identifier: Apache-2.0
// The fast interval loops against the plain double-precision ones.
#include "hal/sim/tile_kernels.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "hal/sim/world_query.hpp"

using namespace g3d::hal;

namespace {

PreparedSolid prepare(const Primitive& p, const std::array<float, 3>& camera_m) {
  PreparedSolid s;
  s.shape = p.shape;
  const float x = camera_m[0] - p.centre_m[0];
  const float y = camera_m[1] - p.centre_m[1];
  s.origin = {p.cos_yaw * x + p.sin_yaw * y, p.cos_yaw * y - p.sin_yaw * x, camera_m[2] - p.centre_m[2]};
  s.half = p.half_m;
  s.cos_yaw = p.cos_yaw;
  s.sin_yaw = p.sin_yaw;
  s.radius = p.shape == Shape::cone ? 0.5F * (p.radius_low_m + p.radius_high_m) : p.radius_low_m;
  s.slope = p.shape == Shape::cone ? (p.radius_high_m - p.radius_low_m) / (2 * p.half_m[2]) : 0.0F;
  return s;
}

}  // namespace

TEST_CASE("tile loops agree with the plain intersections for every shape") {
  World world;
  world.add_box({2, 0.3, 0}, {0.4, 1.0, 1.2}, 25, Material{});
  world.add_sphere({3, 0, 1}, 0.7, Material{});
  world.add_cylinder({2.5, 0, 0}, 0.4, 1.5, Material{});
  world.add_cylinder({6, 0.2, 0}, 0.0125, 2.5, Material{});
  world.add_cone({2, 0, 0}, 0.6, 1.4, 0.0, Material{});
  world.add_cone({2, 0, 0.2}, 0.2, 1.0, 0.7, Material{});
  std::mt19937 rng(1);
  std::normal_distribution<float> normal;
  for (std::size_t n = 0; n < world.primitives().size(); ++n) {
    const Primitive& solid = world.primitives()[n];
    CAPTURE(n);
    int hits = 0;
    int differ = 0;
    for (int round = 0; round < 60; ++round) {
      std::array<float, 3> camera_m = {0.2F * normal(rng), 0.2F * normal(rng), 1.0F + 0.3F * normal(rng)};
      if (round % 6 == 5) camera_m = {solid.centre_m[0] + 0.2F * normal(rng), solid.centre_m[1], 4.0F};
      TileRays rays;
      for (std::size_t i = 0; i < kTilePixels; ++i) {
        const bool aimed = i % 4 != 0;
        const float spread = aimed ? 1.3F : 4.0F;
        rays.x[i] = (solid.centre_m[0] - camera_m[0]) / 3 + spread * solid.half_m[0] / 3 * normal(rng);
        rays.y[i] = (solid.centre_m[1] - camera_m[1]) / 3 + spread * solid.half_m[1] / 3 * normal(rng);
        rays.z[i] = (solid.centre_m[2] - camera_m[2]) / 3 + spread * solid.half_m[2] / 3 * normal(rng);
        if (i % 16 == 7) rays.z[i] = 0.0F;
        if (i % 16 == 9) rays.x[i] = 0.0F;
      }
      TileHits tile;
      tile.depth_m.fill(kNoDepth_m);
      tile.solid.fill(kNoSolid);
      cast_tile(prepare(solid, camera_m), 7, rays, tile);
      for (std::size_t i = 0; i < kTilePixels; ++i) {
        const double expected =
            intersect(solid, {camera_m[0], camera_m[1], camera_m[2]}, {rays.x[i], rays.y[i], rays.z[i]});
        REQUIRE((tile.solid[i] == 7) == (tile.depth_m[i] < kNoDepth_m));
        const bool hit = tile.solid[i] == 7;
        hits += hit ? 1 : 0;
        if (hit != std::isfinite(expected) || (hit && std::abs(tile.depth_m[i] - expected) > 2e-4)) ++differ;
      }
    }
    CHECK(hits > 1000);
    CHECK(differ <= hits / 1000);  // grazing rays
  }
}

TEST_CASE("only what is nearer is written, and a ray along the axis of a pole hits its top") {
  World world;
  world.add_cylinder({0, 0, 0}, 0.1, 1.0, Material{});
  const PreparedSolid solid = prepare(world.primitives()[0], {0.0F, 0.0F, 3.0F});
  TileRays rays;
  rays.x.fill(0.0F);
  rays.y.fill(0.0F);
  rays.z.fill(-1.0F);
  TileHits tile;
  tile.depth_m.fill(5.0F);
  tile.depth_m[3] = 1.5F;
  tile.solid.fill(2);
  cast_tile(solid, 9, rays, tile);
  CHECK(tile.depth_m[0] == Approx(2.0));
  CHECK(tile.solid[0] == 9);
  CHECK(tile.depth_m[3] == 1.5F);
  CHECK(tile.solid[3] == 2);
}
