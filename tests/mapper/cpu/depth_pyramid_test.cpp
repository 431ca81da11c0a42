// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/depth_pyramid.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/support/sample_maps.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper::cpu;

namespace {

DepthPyramid::Range slow_range(const RayEnds& ends, int u0, int v0, int u1, int v1) {
  DepthPyramid::Range range{0xFFFF, 0};
  for (int v = v0; v <= v1; ++v) {
    for (int u = u0; u <= u1; ++u) {
      range.min = std::min(range.min, ends.at(u, v));
      range.max = std::max(range.max, ends.at(u, v));
    }
  }
  return range;
}

}  // namespace

TEST_CASE("a range bounds the ends of its window, and is not wider than that of a window somewhat larger",
          "[threads]") {
  for (const int width : {8, 52, 160}) {
    hal::CameraModel camera = test::small_camera(width);
    camera.height_px += width == 52 ? 1 : 0;
    const SensorGeometry sensor(camera, 0.05F, 0.8F, 3.5F);
    ThreadPool pool(width == 160 ? 3 : 1);
    RayEnds ends(sensor, {}, 3000, true);
    DepthPyramid pyramid(camera.width_px, camera.height_px);
    tests::Random random(7);
    const auto one_of = [&](int count) { return static_cast<int>(random.below(static_cast<std::uint32_t>(count))); };
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
      const hal::Frame frame = test::random_frame(camera, seed);
      ends.compute(frame.depth.get(), best_kernels(), pool);
      pyramid.compute(ends, best_kernels(), pool);
      int too_tight = 0;
      int too_wide = 0;
      for (int i = 0; i < 500; ++i) {
        const int u0 = one_of(camera.width_px);
        const int v0 = one_of(camera.height_px);
        const int u1 = i % 5 == 0 ? u0 : u0 + one_of(camera.width_px - u0);
        const int v1 = i % 7 == 0 ? v0 : v0 + one_of(camera.height_px - v0);
        const DepthPyramid::Range found = pyramid.range(u0, v0, u1, v1);
        const DepthPyramid::Range exact = slow_range(ends, u0, v0, u1, v1);
        too_tight += found.min > exact.min || found.max < exact.max ? 1 : 0;
        const int margin = std::max({4, u1 - u0, v1 - v0});
        const bool at_border =
            u0 < margin || v0 < margin || u1 + margin >= camera.width_px || v1 + margin >= camera.height_px;
        const DepthPyramid::Range wide =
            slow_range(ends, std::max(0, u0 - margin), std::max(0, v0 - margin),
                       std::min(camera.width_px - 1, u1 + margin), std::min(camera.height_px - 1, v1 + margin));
        too_wide += found.max > wide.max || (!at_border && found.min < wide.min) ? 1 : 0;
      }
      REQUIRE(too_tight == 0);
      REQUIRE(too_wide == 0);
    }
  }
}

TEST_CASE("a single near pixel is in the minimum of its own window and of none far away") {
  const hal::CameraModel camera = test::small_camera(160);
  const SensorGeometry sensor(camera, 0.05F, 0.8F, 3.5F);
  ThreadPool pool(1);
  RayEnds ends(sensor, {}, 3000, true);
  DepthPyramid pyramid(camera.width_px, camera.height_px);
  std::vector<std::uint16_t> depth(camera.pixel_count(), 3000);
  depth[static_cast<std::size_t>(60 * camera.width_px + 80)] = 1000;
  ends.compute(depth.data(), best_kernels(), pool);
  pyramid.compute(ends, best_kernels(), pool);
  CHECK(pyramid.range(80, 60, 80, 60).min == 1000);
  CHECK(pyramid.range(0, 0, 159, 119).min <= 1000);
  CHECK(pyramid.range(72, 60, 75, 63).min == 3000);
  CHECK(pyramid.range(20, 20, 40, 40).min == 3000);
  CHECK(pyramid.range(0, 0, 159, 119).max == 3000);
}
