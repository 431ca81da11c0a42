// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>

#include "mapper/files/render.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

const hal::ImageSize kSize{320, 240};

struct Pixel {
  int r, g, b;
};
Pixel at(const std::vector<std::uint8_t>& rgb, int x, int y) {
  const std::size_t i =
      3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(kSize.width_px) + static_cast<std::size_t>(x));
  return {rgb[i], rgb[i + 1], rgb[i + 2]};
}

}  // namespace

TEST_CASE("The top view shows table, sofa and floor where they are, and the unknown grey") {
  const auto room = tests::furnished_room(0.05F);
  RenderOptions options;
  options.size = kSize;
  const auto rgb = render_top(*room, options);
  REQUIRE(rgb.size() == 3 * kSize.pixel_count());
  // The room of 6 x 5 m fills the height: about 46 px per metre, its middle near the picture's
  const Pixel table = at(rgb, 155, 120);
  CHECK(table.r > 1.5 * table.g);
  CHECK(table.r < 170);
  const Pixel sofa = at(rgb, 160 - 115, 120);
  CHECK(sofa.r > 2 * sofa.g);
  const Pixel floor = at(rgb, 160 + 70, 100);
  CHECK(floor.r > floor.b + 40);
  const Pixel outside = at(rgb, 2, 2);
  CHECK(outside.r == Approx(outside.b).margin(20));
  const Pixel shelf = at(rgb, 160 + 60, 14);  // y up: the shelf stands at the highest y
  CHECK(shelf.r < 150);
}

TEST_CASE("Free space over unknown ground is light") {
  VoxelMap map(Grid{0.1F}, {64, 64, 64});
  BlockValues air;
  air.fill(0);
  for (int x = 0; x < 4; ++x) {
    for (int y = 0; y < 4; ++y) REQUIRE(map.write_block(block_of({32768 + 8 * x, 32768 + 8 * y, 32768}), air));
  }
  for (std::size_t i = 0; i < air.size(); ++i)
    air[i] = decode(i).z == 0 ? 32 : 0;  // floor in two corners, to centre on
  REQUIRE(map.write_block(block_of({32768, 32768, 32768}), air));
  REQUIRE(map.write_block(block_of({32768 + 24, 32768 + 24, 32768}), air));
  RenderOptions options;
  options.size = kSize;
  const Pixel middle = at(render_top(map, options), 160, 110);
  CHECK(middle.r > 230);
  CHECK(middle.b > 225);
}
