// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "hal/kinect/depth_registration.hpp"
#include "hal/kinect/sensor_link.hpp"

using namespace g3d::hal::kinect;

namespace {

constexpr std::size_t kPixels = std::size_t{kWidth_px} * kHeight_px;

std::size_t pixel(int u, int v) { return static_cast<std::size_t>(v * kWidth_px + u); }

}  // namespace

TEST_CASE("a point is registered to where the colour camera sees it") {
  Calibration c;
  c.infrared = {590.0, 588.0, 322.0, 240.0};
  c.shift_x_px = 4.0;
  c.shift_y_px = 3.0;
  c.colour = {520.0, 521.0, 318.0, 250.0};
  c.x_m = -0.025;
  c.z_m = 0.01;
  std::vector<std::uint16_t> infrared(kPixels), colour(kPixels);
  infrared[pixel(400, 300)] = 2000;
  DepthRegistration(c).apply(infrared.data(), colour.data());
  // By hand, in metres: infrared frame (x, y, 2), then 2.5 cm to the left and 1 cm ahead.
  const double x_m = (400 - 326.0) / 590.0 * 2.0 - 0.025, y_m = (300 - 243.0) / 588.0 * 2.0, z_m = 2.01;
  const int u = static_cast<int>(std::lround(520.0 * x_m / z_m + 318.0));
  const int v = static_cast<int>(std::lround(521.0 * y_m / z_m + 250.0));
  CHECK(colour[pixel(u, v)] == 2010);
  std::size_t readings = 0;
  for (const std::uint16_t mm : colour) readings += mm != 0;
  CHECK(readings == 1);
}

TEST_CASE("a wall stays a wall, and of two points on one pixel the nearer one is seen") {
  Calibration c;
  std::vector<std::uint16_t> infrared(kPixels, 2500), colour(kPixels);
  // A pole before the wall: seen from the colour camera it hides what is to its side.
  for (int v = 100; v < 400; ++v) {
    for (int u = 300; u < 320; ++u) infrared[pixel(u, v)] = 1000;
  }
  const DepthRegistration registration(c);
  registration.apply(infrared.data(), colour.data());
  std::size_t wall = 0, pole = 0, other = 0;
  for (int v = 120; v < 360; ++v) {
    for (int u = 60; u < 580; ++u) {
      const std::uint16_t mm = colour[pixel(u, v)];
      (mm == 2500 ? wall : mm == 1000 ? pole : other) += 1;
    }
  }
  CHECK(pole > 240U * 15);
  CHECK(wall > 240U * 450);
  CHECK(other < 240U * 40);
  std::vector<std::uint16_t> again(kPixels, 7);
  registration.apply(infrared.data(), again.data());
  CHECK(again == colour);
}
