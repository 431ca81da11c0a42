// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/depth_samples.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "hal/sim/seeded_random.hpp"

using namespace g3d;
using namespace g3d::mapper::align;

namespace {

/// The depth image of the plane n . p = offset_m (camera frame), `noise` in parts of 1/z as a Kinect has it.
std::vector<std::uint16_t> plane_image(const hal::CameraModel& camera, const std::array<double, 3>& n, double offset_m,
                                       double noise = 0.0) {
  hal::SeededRandom random(5);
  std::vector<std::uint16_t> depth(camera.pixel_count());
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      const double x = (u - static_cast<double>(camera.cx_px)) / static_cast<double>(camera.fx_px);
      const double y = (v - static_cast<double>(camera.cy_px)) / static_cast<double>(camera.fy_px);
      const double inverse = (n[0] * x + n[1] * y + n[2]) / offset_m + noise * random.gaussian();
      const double raw = inverse > 0.0 ? 1000.0 / inverse : 0.0;
      depth[static_cast<std::size_t>(v * camera.width_px + u)] =
          static_cast<std::uint16_t>(raw < 65535.0 ? std::lround(raw) : 0);
    }
  }
  return depth;
}

}  // namespace

TEST_CASE("samples of a tilted plane lie on it and face the camera", "[mapper][align]") {
  const hal::CameraModel camera;
  const double s = std::sqrt(0.5);
  const std::array<double, 3> n{0.0, s, s};  // a floor seen at 45 degrees
  DepthSamples samples(camera);
  samples.compute(plane_image(camera, n, 1.5, 0.002).data());
  REQUIRE(samples.all().size() > 10'000);
  double worst_turn = 0.0;
  double sum_m = 0.0;
  for (const DepthSample& sample : samples.all()) {
    const Vector3f f{static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])};
    sum_m += static_cast<double>(dot(sample.point_m, f)) - 1.5;
    worst_turn = std::max(worst_turn, 1.0 + static_cast<double>(dot(sample.normal, f)));
    CHECK(dot(sample.normal, sample.point_m) < 0.0F);
  }
  CHECK(std::abs(sum_m / static_cast<double>(samples.all().size())) < 0.0005);
  CHECK(worst_turn < 0.02);  // 11 degrees
}

TEST_CASE("nothing is sampled across an edge, out of bounds, or without readings", "[mapper][align]") {
  const hal::CameraModel camera;
  DepthSamples samples(camera);
  std::vector<std::uint16_t> depth = plane_image(camera, {0, 0, 1}, 2.0);
  SECTION("an edge") {
    for (int v = 0; v < 480; ++v) {
      for (int u = 320; u < 640; ++u) depth[static_cast<std::size_t>(v * 640 + u)] = 3000;
    }
    samples.compute(depth.data());
    REQUIRE(samples.all().size() > 10'000);
    for (const DepthSample& sample : samples.all()) {
      CHECK((std::abs(sample.point_m[2] - 2.0F) < 0.002F || std::abs(sample.point_m[2] - 3.0F) < 0.002F));
      CHECK(sample.normal[2] < -0.999F);
    }
  }
  SECTION("bounds") {
    for (const std::uint16_t raw : {0, 500, 6500, 65535}) {
      std::fill(depth.begin(), depth.end(), raw);
      samples.compute(depth.data());
      CHECK(samples.all().empty());
      CHECK(samples.chosen().empty());
    }
  }
}

TEST_CASE("chosen samples are even in space and bounded in number", "[mapper][align]") {
  const hal::CameraModel camera;
  const std::vector<std::uint16_t> depth = plane_image(camera, {0, 0, 1}, 2.0);
  DepthSamples samples(camera, {.spacing_m = 0.1F});
  samples.compute(depth.data());
  const double area_m2 = 2.0 * 2.0 * (640.0 / 525.0) * (480.0 / 525.0);
  CHECK(static_cast<double>(samples.chosen().size()) == Approx(area_m2 / 0.01).epsilon(0.15));
  DepthSamples few(camera, {.spacing_m = 0.1F, .most_chosen = 50});
  few.compute(depth.data());
  CHECK(few.chosen().size() == 50);
}

TEST_CASE("a nearer sample weighs more, and a small image is sampled pixel by pixel", "[mapper][align]") {
  const hal::CameraModel small{
      .width_px = 160, .height_px = 120, .fx_px = 131, .fy_px = 131, .cx_px = 79.5F, .cy_px = 59.5F};
  DepthSamples samples(small);
  samples.compute(plane_image(small, {0, 0, 1}, 1.0).data());
  REQUIRE(samples.all().size() == 156U * 116U);
  const float near_weight = samples.all().front().weight;
  samples.compute(plane_image(small, {0, 0, 1}, 3.0).data());
  CHECK(samples.all().front().weight < near_weight / 4.0F);
  CHECK(near_weight <= 1.0F);
}
