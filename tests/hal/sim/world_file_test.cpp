// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/world_file.hpp"

#include <catch2/catch.hpp>
#include <string>

#include "hal/sim/world_query.hpp"

using namespace g3d::hal;
using Catch::Matchers::Contains;

TEST_CASE("each kind of line becomes its solids") {
  const auto world = parse_world(
      "# all kinds\n"
      "box 1 2 0  1 2 3  30  color=#102030 texture=checker:0.25 color2=#ffffff dark\n"
      "sphere 0 0 1 0.5 glass\n"
      "cylinder 0 0 0 0.2 1\n"
      "pole 1 1 0 0.01 2   # thin\n"
      "cone 2 2 0 0.5 1\n"
      "cone 2 3 0 0.5 1 0.2\n"
      "stairs 5 5 0 1 0.3 0.2 4 90\n"
      "shelves 6 6 0 1 0.3 2 5\n"
      "floor 0 0 0 10 10 0.1\n"
      "room 20 20 0 4 4 2.5 0.1 floor=#ff0000 floor2=#00ff00 ceiling=#0000ff\n"
      "room 30 20 0 4 4 2.5 0.1 open\n"
      "person 1.8 0.25 0,1,1 2,3,3.5 texture=stripes:0.1\n",
      "w");
  REQUIRE(world);
  const auto& solids = world.value().primitives();
  CHECK(solids.size() == 6 + 4 + 7 + 1 + 6 + 5 + 2);
  CHECK(solids[0].material.colour == Rgb{0x10, 0x20, 0x30});
  CHECK(solids[0].material.texture == Texture::checker);
  CHECK(solids[0].material.texture_size_m == 0.25F);
  CHECK(solids[0].material.dark);
  CHECK(solids[0].centre_m == std::array<float, 3>{1.0F, 2.0F, 1.5F});
  CHECK(solids[0].cos_yaw == Approx(std::sqrt(0.75)));
  CHECK(solids[1].material.glass);
  CHECK(solids[4].radius_high_m == 0.0F);
  CHECK(solids[5].radius_high_m == 0.2F);
  const std::size_t room = 6 + 4 + 7 + 1;
  CHECK(solids[room + 4].material.colour == Rgb{255, 0, 0});
  CHECK(solids[room + 4].material.texture == Texture::checker);
  CHECK(solids[room + 5].material.colour == Rgb{0, 0, 255});
  REQUIRE(world.value().movers().size() == 1);
  CHECK(world.value().movers()[0].waypoints.size() == 2);
  CHECK(solids.back().mover == 0);
}

TEST_CASE("starts are kept in order, their headings within half a turn") {
  const auto world =
      parse_world("box 0 0 0 1 1 1\nstart 1.5 -2 90\nstart 0 0 -180\nstart 0 1 180 # left\nstart 0 2 -1170\n", "w");
  REQUIRE(world);
  const auto& starts = world.value().starts();
  REQUIRE(starts.size() == 4);
  CHECK(starts[0].x_m == 1.5);
  CHECK(starts[0].y_m == -2.0);
  CHECK(starts[0].heading_rad == Approx(1.5707963));
  CHECK(starts[1].heading_rad == Approx(3.14159265));
  CHECK(starts[2].heading_rad == Approx(3.14159265));
  CHECK(starts[3].heading_rad == Approx(-1.5707963));
  CHECK(world.value().primitives().size() == 1);
}

TEST_CASE("errors of a world file name file and line") {
  struct Row {
    const char* text;
    Reason reason;
    const char* says;
  };
  const Row rows[] = {
      {"", Reason::malformed, "w.world: no solid"},
      {"# nothing\n", Reason::malformed, "no solid"},
      {"box 0 0 0 1 1 1\nball 0 0 0 1\n", Reason::malformed, "w.world:2: 'ball' is not known"},
      {"box 0 0 0 1 1\n", Reason::malformed, "w.world:1: box needs a number for size_z"},
      {"box 0 0 0 1 1 0\n", Reason::out_of_range, "size_z is 0, allowed are 0.001 to 1000"},
      {"box 0 0 0 1 1 -1\n", Reason::out_of_range, "size_z"},
      {"box 0 0 1e9 1 1 1\n", Reason::out_of_range, "z is 1000000000"},
      {"box nan 0 0 1 1 1\n", Reason::malformed, "needs a number for x"},
      {"box 0 0 0 1 1 1 0 5\n", Reason::malformed, "'5' is not known here"},
      {"box 0 0 0 1 1 1 color=red\n", Reason::malformed, "'red' is not a colour"},
      {"box 0 0 0 1 1 1 color=#12345g\n", Reason::malformed, "is not a colour"},
      {"box 0 0 0 1 1 1 texture=dots:1\n", Reason::malformed, "texture is checker"},
      {"box 0 0 0 1 1 1 texture=checker\n", Reason::malformed, "texture size"},
      {"box 0 0 0 1 1 1 texture=checker:0\n", Reason::out_of_range, "texture size is 0"},
      {"box 0 0 0 1 1 1 open\n", Reason::malformed, "'open' is not known here"},
      {"pole 0 0 0 0.5 2\n", Reason::out_of_range, "radius is 0.5, allowed are 0.001 to 0.1"},
      {"stairs 0 0 0 1 1 1 201\n", Reason::out_of_range, "steps"},
      {"shelves 0 0 0 1 1 1 1\n", Reason::out_of_range, "boards"},
      {"start 0 0\n", Reason::malformed, "start needs a number for heading"},
      {"start 0 0 1e5\n", Reason::out_of_range, "heading is 100000"},
      {"start 0 0 0 dark\n", Reason::malformed, "nothing else"},
      {"start 0 0 0\n", Reason::malformed, "no solid"},
      {"person 1.8 0.2\n", Reason::malformed, "at least one waypoint"},
      {"person 1.8 0.2 0,1\n", Reason::malformed, "t,x,y"},
      {"person 1.8 0.2 1,0,0 1,1,1\n", Reason::malformed, "must ascend"},
      {"person 1.8 0.2 1,0,0,0\n", Reason::malformed, "y is '0,0'"},
  };
  for (const Row& row : rows) {
    CAPTURE(row.text);
    const auto world = parse_world(row.text, "w.world");
    REQUIRE_FALSE(world.ok());
    CHECK(world.error().reason == row.reason);
    CHECK_THAT(world.error().text, Contains(row.says));
  }
}

TEST_CASE("the number of solids is bounded, composed ones count in full") {
  std::string text;
  for (int i = 0; i < 21; ++i) text += "stairs 0 0 0 1 0.1 0.1 200\n";
  const auto world = parse_world(text, "w");
  REQUIRE_FALSE(world.ok());
  CHECK(world.error().reason == Reason::too_large);
  CHECK_THAT(world.error().text, Contains("w:21:"));
}

TEST_CASE("the number of starts is bounded") {
  std::string text = "box 0 0 0 1 1 1\n";
  for (int i = 0; i < 65; ++i) text += "start 0 0 0\n";
  const auto world = parse_world(text, "w");
  REQUIRE_FALSE(world.ok());
  CHECK(world.error().reason == Reason::too_large);
}
