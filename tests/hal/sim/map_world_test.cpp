// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/map_world.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "hal/sim/world_query.hpp"

using namespace g3d::hal;
using Catch::Matchers::Contains;

namespace {

GreyImage picture(int width, int height, const std::string& rows) {
  GreyImage image{{width, height}, 255, {}};
  for (const char c : rows) {
    image.pixels.push_back(c == '#' ? std::uint8_t{0} : c == '.' ? std::uint8_t{254} : std::uint8_t{205});
  }
  return image;
}

}  // namespace

TEST_CASE("a yaml file of map_server is understood as map_server writes it") {
  const auto yaml = parse_map_yaml(
      "# saved\nimage: \"my map.pgm\"   # picture\nmode: trinary\nresolution: 0.050000\norigin: [-12.5, 3, 0.000000]\n"
      "negate: 1\r\noccupied_thresh: 0.7\nfree_thresh: 0.2\n\n",
      "m.yaml");
  REQUIRE(yaml);
  CHECK(yaml.value().image == "my map.pgm");
  CHECK(yaml.value().resolution_m == 0.05);
  CHECK(yaml.value().origin_x_m == -12.5);
  CHECK(yaml.value().origin_y_m == 3.0);
  CHECK(yaml.value().negate);
  CHECK(yaml.value().occupied_thresh == 0.7);
  CHECK(yaml.value().free_thresh == 0.2);
}

TEST_CASE("errors of a map's yaml file name file and line") {
  struct Row {
    const char* text;
    Reason reason;
    const char* says;
  };
  const Row rows[] = {
      {"resolution: 0.05\n", Reason::malformed, "no line `image"},
      {"image: a.pgm\n", Reason::malformed, "no line `resolution"},
      {"image: a.pgm\nresolution: 0\n", Reason::out_of_range, "m.yaml:2: resolution is 0"},
      {"image: a.pgm\nresolution: x\n", Reason::malformed, "m.yaml:2:"},
      {"image: a.pgm\nresolution: 0.1\norigin: 3\n", Reason::malformed, "m.yaml:3: origin is written as"},
      {"image: a.pgm\nresolution: 0.1\norigin: [1, 2]\n", Reason::malformed, "three numbers"},
      {"image: a.pgm\nresolution: 0.1\norigin: [1, 2, 3, 4]\n", Reason::malformed, "three numbers"},
      {"image: a.pgm\nresolution: 0.1\norigin: [1, 2, 1.57]\n", Reason::unsupported, "turned map"},
      {"image: a.pgm\nresolution: 0.1\nnegate: 2\n", Reason::malformed, "negate is 0 or 1"},
      {"image: a.pgm\nresolution: 0.1\nfree_thresh: 0.9\n", Reason::malformed, "above occupied_thresh"},
      {"nonsense\n", Reason::malformed, "m.yaml:1: expected"},
  };
  for (const Row& row : rows) {
    CAPTURE(row.text);
    const auto yaml = parse_map_yaml(row.text, "m.yaml");
    REQUIRE_FALSE(yaml.ok());
    CHECK(yaml.error().reason == row.reason);
    CHECK_THAT(yaml.error().text, Contains(row.says));
  }
}

TEST_CASE("occupied cells are walls, unknown ones only beside free ones, the picture's top is the far side") {
  MapYaml yaml;
  yaml.resolution_m = 1.0;
  const auto made = make_map_world(yaml,
                                   picture(5, 4,
                                           "??.??"
                                           "#...#"
                                           "#...#"
                                           "#####"),
                                   {}, "m.yaml");
  REQUIRE(made);
  const World& world = made.value();
  const auto solid = [&](double x, double y) { return is_solid(world, 0, {x, y, 1.0}); };
  CHECK(solid(0.5, 0.5));
  CHECK(solid(2.5, 0.5));
  CHECK(solid(0.5, 1.5));
  CHECK_FALSE(solid(2.5, 1.5));
  CHECK_FALSE(solid(2.5, 3.5));  // the free cell on the upper border
  CHECK(solid(1.5, 3.5));        // unknown beside free
  CHECK_FALSE(solid(0.5, 4.5));  // beyond, beside nothing free
  CHECK(solid(2.5, 4.5));        // beyond the border, but beside the free cell: closed
  CHECK(cast_ray(world, 0, {2.5, 1.5, 1.0}, {1, 0, 0}).t == Approx(1.5));
  CHECK(cast_ray(world, 0, {2.5, 1.5, 1.0}, {0, 1, 0}).t == Approx(2.5));
  CHECK(cast_ray(world, 0, {2.5, 1.5, 1.0}, {0, 0, 1}).t == Approx(1.5));
  CHECK(cast_ray(world, 0, {2.5, 1.5, 1.0}, {0, 0, -1}).t == Approx(1.0));
}

TEST_CASE("a map may be negated, without ceiling, of another height, and must have free cells") {
  MapYaml yaml;
  yaml.resolution_m = 1.0;
  yaml.negate = true;
  const auto made = make_map_world(yaml, picture(2, 1, "#."), {1.2, false}, "m.yaml");
  REQUIRE(made);
  CHECK_FALSE(is_solid(made.value(), 0, {0.5, 0.5, 1.0}));
  CHECK(is_solid(made.value(), 0, {1.5, 0.5, 1.0}));
  CHECK_FALSE(is_solid(made.value(), 0, {1.5, 0.5, 1.3}));
  CHECK(std::isinf(cast_ray(made.value(), 0, {0.5, 0.5, 1.0}, {0, 0, 1}).t));
  CHECK_FALSE(make_map_world(yaml, picture(2, 1, ".."), {}, "m.yaml").ok());
  yaml.resolution_m = 10.0;
  yaml.origin_x_m = 990.0;
  CHECK(make_map_world(yaml, picture(200, 1, std::string(200, '#')), {}, "m").error().reason == Reason::out_of_range);
}

TEST_CASE("real floor plans load, and no ray leaves them", "[slow]") {
  const char* env = std::getenv("G3D_DATA");
  const std::filesystem::path data = env != nullptr ? env : "../shared/data";
  int loaded = 0;
  for (const char* name : {"maps/aws_small_house.yaml", "maps/brsu_c069.yaml", "maps/willow-2010-02-18-0.10.yaml",
                           "lidar2d/intel.yaml", "lidar2d/freiburg-079.yaml"}) {
    if (!std::filesystem::exists(data / name)) continue;
    CAPTURE(name);
    ++loaded;
    const auto world = load_map_world((data / name).string());
    if (!world.ok()) FAIL(world.error().text);
    const GridWalls& grid = *world.value().grid();
    // From the cell that is farthest from all walls within the building.
    int best = 0;
    std::array<double, 3> eye{};
    for (int j = 0; j < grid.height_cells(); ++j) {
      for (int i = 0; i < grid.width_cells(); ++i) {
        const double r = grid.cell_m();
        const std::array<double, 3> p = {grid.origin_m()[0] + (i + 0.5) * r, grid.origin_m()[1] + (j + 0.5) * r, 1.0};
        if (grid.distance(i, j) <= best || grid.distance(i, j) > 60) continue;
        bool closed = true;
        for (int k = 0; k < 16 && closed; ++k) {
          closed = std::isfinite(cast_ray(world.value(), 0, p, {std::cos(0.4 * k), std::sin(0.4 * k), 0.0}).t);
        }
        if (!closed) continue;
        best = grid.distance(i, j);
        eye = p;
      }
    }
    REQUIRE(best > 5);
    for (int k = 0; k < 720; ++k) {
      REQUIRE(std::isfinite(cast_ray(world.value(), 0, eye, {std::cos(0.00873 * k), std::sin(0.00873 * k), 0.0}).t));
    }
  }
  if (loaded == 0) WARN("no floor plans here; set G3D_DATA to run this case on real ones");
}
