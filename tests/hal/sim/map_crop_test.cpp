// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/map_crop.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "hal/sim/world_query.hpp"

using namespace g3d::hal;
using Catch::Matchers::Contains;

namespace {

/// Pixels count up from the far left.
GreyImage numbered(int width, int height) {
  GreyImage image{{width, height}, 255, std::vector<std::uint8_t>(static_cast<std::size_t>(width * height))};
  std::iota(image.pixels.begin(), image.pixels.end(), std::uint8_t{0});
  return image;
}

MapYaml plan_at(double x_m, double y_m, double resolution_m) {
  MapYaml yaml;
  yaml.resolution_m = resolution_m;
  yaml.origin_x_m = x_m;
  yaml.origin_y_m = y_m;
  return yaml;
}

}  // namespace

TEST_CASE("a crop keeps the cells whose middle lies within, where they are") {
  GreyImage image = numbered(6, 4);
  MapYaml yaml = plan_at(-1.0, 2.0, 0.5);
  // Columns 1..3 (middles -0.25, 0.25, 0.75), rows 0..1 from below (middles 2.25, 2.75).
  REQUIRE(crop_map(yaml, image, {-0.3, 1.0, 0.75, 2.9}, "m.yaml"));
  CHECK(image.size.width_px == 3);
  CHECK(image.size.height_px == 2);
  CHECK(image.pixels == std::vector<std::uint8_t>{13, 14, 15, 19, 20, 21});
  CHECK(yaml.origin_x_m == Approx(-0.5));
  CHECK(yaml.origin_y_m == Approx(2.0));
  CHECK(yaml.resolution_m == 0.5);
}

TEST_CASE("a crop beyond the map keeps all of it, one beside it is an error that says where the map lies") {
  GreyImage image = numbered(6, 4);
  MapYaml yaml = plan_at(-1.0, 2.0, 0.5);
  REQUIRE(crop_map(yaml, image, {-100, -100, 1e12, 100}, "m.yaml"));
  CHECK(image.pixels == numbered(6, 4).pixels);
  CHECK(yaml.origin_x_m == -1.0);
  for (const FloorRectangle& crop : {FloorRectangle{3, 2, 4, 4}, FloorRectangle{-9, 2, -1.1, 4},
                                     FloorRectangle{-1, 5, 2, 6}, FloorRectangle{0.1, 2, 0.2, 4}}) {
    const auto made = crop_map(yaml, image, crop, "m.yaml");
    REQUIRE_FALSE(made.ok());
    CHECK(made.error().reason == Reason::bad_usage);
    CHECK_THAT(made.error().text, Contains("m.yaml") && Contains("from -1,2 to 2,4 m"));
  }
  CHECK(image.pixels == numbered(6, 4).pixels);
}

TEST_CASE("a world that is raised from a piece is closed at its border and ends there") {
  GreyImage image{{9, 3}, 255, std::vector<std::uint8_t>(27, 254)};
  MapYaml yaml = plan_at(0.0, 0.0, 1.0);
  REQUIRE(crop_map(yaml, image, {2, 0, 6, 3}, "m.yaml"));
  const auto made = make_map_world(yaml, image, {}, "m.yaml");
  REQUIRE(made);
  CHECK(cast_ray(made.value(), 0, {4.5, 1.5, 1.0}, {1, 0, 0}).t == Approx(1.5));
  CHECK(cast_ray(made.value(), 0, {4.5, 1.5, 1.0}, {-1, 0, 0}).t == Approx(2.5));
  CHECK(made.value().grid()->width_cells() == 6);
}
