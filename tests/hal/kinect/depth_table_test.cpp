// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <vector>

#include "hal/kinect/depth_table.hpp"

using namespace g3d::hal::kinect;

TEST_CASE("readings are corrected as the calibration says; none stays none, and what is too far is none") {
  Calibration c;
  c.depth_offset_m = 0.01;
  c.depth_scale = 1.02;
  c.depth_quadratic_perm = -0.001;
  const std::vector<std::uint16_t> reported{0, 1000, 2000, 3500, 10000, 10001, 65535};
  std::vector<std::uint16_t> got(reported.size());
  DepthTable(c).apply(reported.data(), reported.size(), got.data());
  CHECK(got == std::vector<std::uint16_t>{0, 1029, 2046, 3568, 10110, 0, 0});
  c = {};
  c.depth_offset_m = -0.5;
  DepthTable(c).apply(reported.data(), reported.size(), got.data());
  CHECK(got == std::vector<std::uint16_t>{0, 500, 1500, 3000, 9500, 0, 0});
  const std::uint16_t near = 400;
  DepthTable(c).apply(&near, 1, got.data());
  CHECK(got[0] == 0);
}
