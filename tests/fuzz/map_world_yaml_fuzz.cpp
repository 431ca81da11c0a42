// SPDX-License-Identifier: Apache-2.0
// Yaml files of floor plans: any bytes give values within their ranges or an error; with a small picture they make a
// world or another error.
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "hal/sim/map_world.hpp"
#include "hal/sim/world_query.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  using namespace g3d::hal;
  const auto yaml = parse_map_yaml({reinterpret_cast<const char*>(data), size_bytes}, "fuzz.yaml");
  if (!yaml) {
    if (yaml.error().text.find("fuzz.yaml") != 0) std::abort();
    return 0;
  }
  if (!(yaml.value().resolution_m >= 0.001 && yaml.value().resolution_m <= 10.0)) std::abort();
  GreyImage image{{5, 3}, 255, {0, 254, 205, 254, 0, 0, 254, 254, 100, 0, 0, 0, 205, 0, 255}};
  const auto world = make_map_world(yaml.value(), image, {}, "fuzz.yaml");
  if (!world) return 0;
  const double x = yaml.value().origin_x_m + 1.5 * yaml.value().resolution_m;
  const double y = yaml.value().origin_y_m + 1.5 * yaml.value().resolution_m;
  if (std::isnan(cast_ray(world.value(), 0, {x, y, 1.0}, {1.0, 0.3, 0.1}).t)) std::abort();
  return 0;
}
