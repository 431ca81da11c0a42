// SPDX-License-Identifier: Apache-2.0
// World files: any bytes give a world within its bounds or an error with a text; a world that is read can be looked at.
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "hal/sim/world_file.hpp"
#include "hal/sim/world_query.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  using namespace g3d::hal;
  const auto world = parse_world({reinterpret_cast<const char*>(data), size_bytes}, "fuzz.world");
  if (!world) {
    if (world.error().text.find("fuzz.world") != 0) std::abort();
    return 0;
  }
  if (world.value().primitives().empty() || world.value().primitives().size() > kMaxPrimitives) std::abort();
  for (const Primitive& solid : world.value().primitives()) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!std::isfinite(solid.centre_m[k]) || !(solid.half_m[k] > 0.0F)) std::abort();
    }
  }
  if (world.value().starts().size() > kMaxStarts) std::abort();
  for (const PlanarPose& start : world.value().starts()) {
    if (!(std::abs(start.x_m) <= kMaxCoordinate_m) || !(std::abs(start.heading_rad) < 3.15)) std::abort();
  }
  const RayHit hit = cast_ray(world.value(), 1'000'000'000, {0.1, 0.2, 0.3}, {1.0, 0.5, 0.25});
  if (std::isnan(hit.t) || hit.t < 0.0) std::abort();
  return 0;
}
