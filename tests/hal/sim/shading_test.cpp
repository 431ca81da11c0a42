// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/shading.hpp"

#include <catch2/catch.hpp>

using namespace g3d::hal;

namespace {

int brightness(const Rgb& c) { return c.r + c.g + c.b; }

PreparedSolid wall_ahead() {
  PreparedSolid wall;  // a slab 2 m ahead along +x, seen from its middle
  wall.half = {0.1F, 4.0F, 2.0F};
  wall.origin = {-2.1F, 0.0F, 0.0F};
  return wall;
}

}  // namespace

TEST_CASE("the cosine of incidence is that of the face which was hit") {
  const Material grey;
  CHECK(shade_solid(wall_ahead(), grey, {1, 0, 0}, 2.0F, 1.0F).cos_incidence == Approx(1.0));
  CHECK(shade_solid(wall_ahead(), grey, {1, 1, 0}, 2.0F, 1.0F / std::sqrt(2.0F)).cos_incidence ==
        Approx(std::sqrt(0.5)));

  PreparedSolid ball;
  ball.shape = Shape::sphere;
  ball.radius = 0.5F;
  ball.half = {0.5F, 0.5F, 0.5F};
  ball.origin = {-2.0F, 0.3F, 0.0F};
  CHECK(shade_solid(ball, grey, {1, 0, 0}, 1.6F, 1.0F).cos_incidence == Approx(0.8));

  PreparedSolid post;
  post.shape = Shape::cylinder;
  post.radius = 0.5F;
  post.half = {0.5F, 0.5F, 1.0F};
  post.origin = {0.0F, 0.0F, 3.0F};
  CHECK(shade_solid(post, grey, {0, 0, -1}, 2.0F, 1.0F).cos_incidence == Approx(1.0));  // its lid

  PreparedSolid cone;  // radius 1 below, 0 on top, 2 m high: the mantle leans by atan(1/2)
  cone.shape = Shape::cone;
  cone.radius = 0.5F;
  cone.slope = -0.5F;
  cone.half = {1.0F, 1.0F, 1.0F};
  cone.origin = {-3.0F, 0.0F, 0.0F};
  CHECK(shade_solid(cone, grey, {1, 0, 0}, 2.5F, 1.0F).cos_incidence == Approx(2.0 / std::sqrt(5.0)));
}

TEST_CASE("a checker changes colour from one square to the next and not within one") {
  Material checker;
  checker.colour = {250, 0, 0};
  checker.second_colour = {0, 0, 250};
  checker.texture = Texture::checker;
  checker.texture_size_m = 0.5F;
  const auto is_red = [&](float y, float z) {
    const Rgb c = shade_solid(wall_ahead(), checker, {1, y / 2, z / 2}, 2.0F, 1.0F).colour;
    return c.r > c.b;
  };
  CHECK(is_red(0.1F, 0.1F) == is_red(0.4F, 0.4F));
  CHECK(is_red(0.1F, 0.1F) != is_red(0.6F, 0.1F));
  CHECK(is_red(0.1F, 0.1F) != is_red(0.1F, 0.6F));
  CHECK(is_red(0.1F, 0.1F) == is_red(0.6F, 0.6F));
}

TEST_CASE("faces turned otherwise and farther away look different") {
  const Material grey;
  PreparedSolid box;
  box.half = {0.5F, 0.5F, 0.5F};
  box.origin = {-2.0F, 0.0F, 0.0F};
  const Rgb front = shade_solid(box, grey, {1, 0, 0}, 1.5F, 1.0F).colour;
  const Rgb far = shade_solid(box, grey, {0.25F, 0, 0}, 6.0F, 4.0F).colour;
  box.origin = {0.0F, 0.0F, 2.0F};
  const Rgb top = shade_solid(box, grey, {0, 0, -1}, 1.5F, 1.0F).colour;
  CHECK(brightness(top) > brightness(front));
  CHECK(brightness(far) < brightness(front));
}

TEST_CASE("a pane moves a colour a quarter of the way to its own") {
  CHECK(tint({100, 100, 100}, {200, 0, 100}) == Rgb{125, 75, 100});
}

TEST_CASE("grid walls have a dark skirting and patches of colour") {
  const GridWalls grid(2, 2, 1.0F, {0, 0}, 0.0F, 2.5F, {1, 1, 1, 1});
  const Shade wall = shade_grid(grid, 0, {-2, 0.5F, 1}, {1, 0, 0}, 2.0F, 1.0F);
  const Shade low = shade_grid(grid, 0, {-2, 0.5F, 0.05F}, {1, 0, 0}, 2.0F, 1.0F);
  CHECK(wall.cos_incidence == Approx(1.0));
  CHECK(brightness(low.colour) < brightness(wall.colour));
  int distinct = 0;
  Rgb last{};
  for (float y = 0; y < 40; y += 2.5F) {
    const Rgb c = shade_grid(grid, 0, {-2, y, 1}, {1, 0, 0}, 2.0F, 1.0F).colour;
    distinct += c == last ? 0 : 1;
    last = c;
  }
  CHECK(distinct > 5);
}

TEST_CASE("the sky gets deeper upwards") {
  CHECK(brightness(shade_sky({0, 0, 1}, 1.0F)) < brightness(shade_sky({1, 0, 0}, 1.0F)));
}
