// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/world.hpp"

#include <catch2/catch.hpp>

#include "hal/sim/world_query.hpp"

using namespace g3d::hal;

TEST_CASE("stairs climb along their own x") {
  World world;
  world.add_stairs({1, 2, 0}, 0.8, 0.3, 0.2, 3, 90, Material{});
  REQUIRE(world.primitives().size() == 3);
  // Turned by 90 degrees they climb along +y, from y = 2 on.
  CHECK(is_solid(world, 0, {1.0, 2.15, 0.1}));
  CHECK_FALSE(is_solid(world, 0, {1.0, 2.15, 0.3}));
  CHECK(is_solid(world, 0, {1.3, 2.75, 0.55}));
  CHECK_FALSE(is_solid(world, 0, {1.5, 2.75, 0.55}));
  CHECK_FALSE(is_solid(world, 0, {1.0, 1.95, 0.1}));
}

TEST_CASE("shelves are boards between two sides, open in between") {
  World world;
  world.add_shelves({0, 0, 0}, {1.0, 0.3, 1.62}, 5, 0, Material{});
  REQUIRE(world.primitives().size() == 7);
  CHECK(is_solid(world, 0, {0.0, 0.0, 0.41}));  // second board: 0.40 to 0.42
  CHECK(is_solid(world, 0, {0.0, 0.0, 1.61}));  // top
  CHECK(is_solid(world, 0, {0.49, 0.0, 1.0}));  // side
  CHECK_FALSE(is_solid(world, 0, {0.0, 0.0, 0.3}));
  CHECK_FALSE(is_solid(world, 0, {0.0, 0.16, 0.41}));
}

TEST_CASE("a room is closed: every ray from inside ends in its shell") {
  World world;
  world.add_room({1, 1, 0}, {4, 3, 2.5}, 0.1, Material{}, Material{}, Material{});
  REQUIRE(world.primitives().size() == 6);
  for (int a = 0; a < 40; ++a) {
    for (int b = 0; b < 20; ++b) {
      const double yaw = 0.157 * a;
      const double up = -1.5 + 0.157 * b;
      const RayHit hit = cast_ray(world, 0, {1.2, 0.8, 1.1},
                                  {std::cos(yaw) * std::cos(up), std::sin(yaw) * std::cos(up), std::sin(up)});
      REQUIRE(hit.t > 0.9);
      REQUIRE(hit.t < 5.0);
    }
  }
  World open;
  open.add_room({0, 0, 0}, {4, 3, 2.5}, 0.1, Material{}, Material{}, std::nullopt);
  CHECK(open.primitives().size() == 5);
  CHECK(cast_ray(open, 0, {0, 0, 1}, {0, 0, 1}).t > 1e9);
}

TEST_CASE("a person follows the waypoints and rests at both ends") {
  World world;
  world.add_person(1.8, 0.25, Material{}, Mover{{{1.0, 0.0, 0.0}, {3.0, 4.0, 2.0}, {4.0, 4.0, 3.0}}});
  const auto at = [&](double t_s) { return world.mover_at(0, static_cast<TimeNs>(t_s * 1e9)); };
  CHECK(at(0.0) == std::array<float, 2>{0.0F, 0.0F});
  CHECK(at(2.0) == std::array<float, 2>{2.0F, 1.0F});
  CHECK(at(3.0) == std::array<float, 2>{4.0F, 2.0F});
  CHECK(at(3.5) == std::array<float, 2>{4.0F, 2.5F});
  CHECK(at(99.0) == std::array<float, 2>{4.0F, 3.0F});
  CHECK(is_solid(world, 2'000'000'000, {2.0, 1.0, 0.9}));
  CHECK(is_solid(world, 2'000'000'000, {2.0, 1.0, 1.7}));  // the head
  CHECK_FALSE(is_solid(world, 0, {2.0, 1.0, 0.9}));
}

TEST_CASE("a floor's upper side is where it was asked for") {
  World world;
  world.add_floor({0, 0, 0.5}, 2, 2, 0.2, Material{});
  CHECK(is_solid(world, 0, {0, 0, 0.45}));
  CHECK_FALSE(is_solid(world, 0, {0, 0, 0.55}));
  CHECK_FALSE(is_solid(world, 0, {0, 0, 0.25}));
}

TEST_CASE("a moving cylinder is where its mover is put") {
  World world;
  world.add_box({5, 5, 0}, {1, 1, 1}, 0, {});
  const std::size_t mover = world.add_moving_cylinder(0.1, 0.2, 0.5, {});
  REQUIRE(world.movers().size() == mover + 1);
  const std::array<std::array<float, 2>, 1> places = {{{3.0F, -1.0F}}};
  const Primitive p = world.placed(1, places);
  CHECK(p.centre_m[0] == 3.0F);
  CHECK(p.centre_m[1] == -1.0F);
  CHECK(p.centre_m[2] == Approx(0.35));
  CHECK(world.placed(0, places).centre_m[0] == 5.0F);
}
