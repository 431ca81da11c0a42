// SPDX-License-Identifier: Apache-2.0
// Against a plain version that walks from every blind pixel to its four neighbours, and on pictures made for one rule.
#include "mapper/cpu/ray_ends.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/plain_mapper.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper::cpu;

namespace {

constexpr std::uint16_t kMask = 3000;

std::vector<std::uint16_t> ends_of(const RayEnds& ends, const hal::CameraModel& camera) {
  std::vector<std::uint16_t> all;
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) all.push_back(ends.at(u, v));
  }
  return all;
}

/// A picture of one depth with a hole, for the rules on holes.
struct Picture {
  hal::CameraModel camera = test::small_camera(40);
  SensorGeometry sensor{camera, 0.05F, 0.8F, 3.5F};
  std::vector<std::uint16_t> depth;
  ThreadPool pool{1};
  RayEnds ends{sensor, {}, kMask, true};

  explicit Picture(std::uint16_t raw) : depth(camera.pixel_count(), raw) {}
  std::uint16_t& at(int u, int v) { return depth[static_cast<std::size_t>(v * camera.width_px + u)]; }
  void paint(int u0, int v0, int u1, int v1, std::uint16_t raw) {
    for (int v = v0; v < v1; ++v) {
      for (int u = u0; u < u1; ++u) at(u, v) = raw;
    }
  }
  void compute() { ends.compute(depth.data(), best_kernels(), pool); }
};

}  // namespace

TEST_CASE("ray ends are those of the plain version, bit by bit", "[threads]") {
  for (const int width : {12, 40, 84, 172}) {
    hal::CameraModel camera = test::small_camera(width);
    camera.height_px -= width % 8 == 0 ? 1 : 0;
    const SensorGeometry sensor(camera, 0.05F, 0.8F, 3.5F);
    const std::vector<std::uint16_t> flat_mask(camera.pixel_count(), kMask);
    std::vector<std::uint16_t> rough_mask(camera.pixel_count());
    for (std::size_t i = 0; i < rough_mask.size(); ++i) rough_mask[i] = static_cast<std::uint16_t>(i * 7919 % 4500);
    for (const int threads : {1, 3}) {
      ThreadPool pool(threads);
      for (const bool carve : {true, false}) {
        RayEnds flat(sensor, {}, kMask, carve);
        RayEnds rough(sensor, rough_mask, kMask, carve);
        for (std::uint64_t seed = 0; seed < 12; ++seed) {
          hal::Frame frame = test::random_frame(camera, seed);
          std::uint16_t* depth = frame.depth.get();
          if (seed == 10) std::fill_n(depth, camera.pixel_count(), std::uint16_t{0});
          if (seed == 11) std::replace(depth, depth + camera.pixel_count(), std::uint16_t{0}, std::uint16_t{2000});
          flat.compute(depth, best_kernels(), pool);
          rough.compute(depth, best_kernels(), pool);
          REQUIRE(ends_of(flat, camera) == test::plain_ray_ends(sensor, depth, flat_mask, carve));
          REQUIRE(ends_of(rough, camera) == test::plain_ray_ends(sensor, depth, rough_mask, carve));
        }
      }
    }
  }
}

TEST_CASE("counts, colour flags and strength belong to the readings") {
  const hal::CameraModel camera = test::small_camera(84);
  const SensorGeometry sensor(camera, 0.05F, 0.8F, 3.5F);
  ThreadPool pool(1);
  RayEnds ends(sensor, {}, kMask, true);
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const hal::Frame frame = test::random_frame(camera, seed);
    ends.compute(frame.depth.get(), best_kernels(), pool);
    RowCounts counts;
    for (int v = 0; v < camera.height_px; ++v) {
      for (int u = 0; u < camera.width_px; ++u) {
        const auto i = static_cast<std::size_t>(v * camera.width_px + u);
        const std::uint16_t raw = frame.depth[i];
        counts.invalid += raw == 0;
        counts.too_near += raw != 0 && raw < 800;
        counts.valid += raw >= 800 && raw <= 3500;
        counts.far += raw > 3500;
        REQUIRE(ends.is_strong(u, v) == (raw != 0));
        if (raw != 0)
          REQUIRE((ends.colour_flags()[i] != 0) == test::plain_gives_colour(camera, frame.depth.get(), u, v));
      }
    }
    CHECK(ends.counts().valid == counts.valid);
    CHECK(ends.counts().too_near == counts.too_near);
    CHECK(ends.counts().far == counts.far);
    CHECK(ends.counts().invalid == counts.invalid);
  }
}

TEST_CASE("the padding around the image stays zero") {
  const hal::CameraModel camera = test::small_camera(40);
  const SensorGeometry sensor(camera, 0.05F, 0.8F, 3.5F);
  ThreadPool pool(1);
  RayEnds ends(sensor, {}, kMask, true);
  const hal::Frame frame = test::random_frame(camera, 4);
  ends.compute(frame.depth.get(), best_kernels(), pool);
  int wrong = 0;
  for (int y = 0; y < camera.height_px + 2 * kImagePadding; ++y) {
    for (int x = 0; x < ends.stride(); ++x) {
      const int u = x - kImagePadding;
      const int v = y - kImagePadding;
      const std::uint16_t cell = ends.padded()[y * ends.stride() + x];
      const bool inside = u >= 0 && v >= 0 && u < camera.width_px && v < camera.height_px;
      wrong += cell == (inside ? ends.at(u, v) : 0) ? 0 : 1;
    }
  }
  CHECK(wrong == 0);
}

TEST_CASE("a dropout in a wall carves to the wall and no farther") {
  Picture wall(2000);
  wall.paint(10, 10, 13, 12, 0);
  wall.compute();
  CHECK(wall.ends.at(11, 11) == 2000);
  CHECK_FALSE(wall.ends.is_strong(11, 11));
}

TEST_CASE("a hole beside something near goes as far as the near thing, not as the far one") {
  Picture scene(3200);
  scene.paint(0, 0, 10, 30, 1500);
  scene.paint(10, 5, 20, 15, 0);
  scene.compute();
  CHECK(scene.ends.at(15, 10) == 1500);
}

TEST_CASE("a hole bounded by far readings goes as far as the mask") {
  Picture sky(6000);
  sky.paint(10, 10, 20, 20, 0);
  sky.compute();
  CHECK(sky.ends.at(15, 15) == kMask);
  CHECK(sky.ends.at(5, 5) == 3500);
}

TEST_CASE("a hole beside something too near carves nothing, and neither does a wholly blind image") {
  Picture hand(2500);
  hand.paint(10, 10, 20, 20, 0);
  hand.at(20, 15) = 600;
  hand.compute();
  CHECK(hand.ends.at(15, 15) == 0);
  CHECK(hand.ends.at(15, 14) == 2500);  // another row, another bound
  CHECK(hand.ends.at(20, 15) == 0);
  Picture blind(0);
  blind.compute();
  CHECK(blind.ends.at(0, 0) == 0);
  CHECK(blind.ends.at(20, 15) == 0);
  CHECK(blind.ends.counts().invalid == blind.camera.pixel_count());
}
