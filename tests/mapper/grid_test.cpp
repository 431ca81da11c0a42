// SPDX-License-Identifier: Apache-2.0
#include "mapper/grid.hpp"

#include <catch2/catch.hpp>

using namespace g3d::mapper;

TEST_CASE("the thesis's example lands on the thesis's integers") {
  const Grid grid{0.05F};
  CHECK(grid.to_index(1.34442F, 2.00453F, 0.43599F) == VoxelIndex{32794, 32808, 32776});
  CHECK(grid.to_index(-0.43599F) == 32759);
}

TEST_CASE("zero belongs to the voxel below it, because voxels are open below and closed above") {
  const Grid grid{0.5F};  // a power of two, so that boundaries are exact
  CHECK(grid.to_index(0.0F) == 32767);
  CHECK(grid.to_index(-0.0F) == 32767);
  CHECK(grid.to_index(0.001F) == 32768);
  CHECK(grid.to_index(0.5F) == 32768);
  CHECK(grid.to_index(0.501F) == 32769);
  CHECK(grid.to_index(-0.499F) == 32767);
  CHECK(grid.to_index(-0.5F) == 32766);
}

TEST_CASE("every integer comes back from the centre of its voxel") {
  for (const float resolution_m : {0.01F, 0.02F, 0.05F, 0.1F, 0.5F, 1.0F}) {
    const Grid grid{resolution_m};
    int wrong = 0;
    for (std::int32_t k = 0; k < kAxisCells; ++k)
      wrong += grid.to_index(static_cast<float>(grid.centre_m(k))) != k ? 1 : 0;
    CHECK(wrong == 0);
  }
}

TEST_CASE("a centre is half a voxel below the upper corner that the thesis decodes") {
  const Grid grid{0.05F};
  CHECK(grid.centre_m(32794) == Approx(1.325));  // (32794 - 32767.5) * 0.05
  CHECK(grid.centre_m(32759) == Approx(-0.425));
  const auto centre_m = grid.centre_m(VoxelIndex{32794, 32808, 32776});
  CHECK(centre_m[0] == Approx(1.325));
  CHECK(centre_m[1] == Approx(2.025));
  CHECK(centre_m[2] == Approx(0.425));
}

TEST_CASE("a point is never further than half a voxel from the centre it is given") {
  const Grid grid{0.02F};
  for (int i = -5000; i <= 5000; ++i) {
    const float x_m = static_cast<float>(i) * 0.00317F;
    const double off_m = grid.centre_m(grid.to_index(x_m)) - static_cast<double>(x_m);
    REQUIRE(std::abs(off_m) <= 0.5 * 0.02 + 1e-5);
  }
}

TEST_CASE("the grid ends at 0 and 65535 on every axis") {
  CHECK(is_inside_grid(0));
  CHECK(is_inside_grid(65535));
  CHECK_FALSE(is_inside_grid(-1));
  CHECK_FALSE(is_inside_grid(65536));
  CHECK(is_inside_grid(VoxelIndex{0, 65535, 7}));
  CHECK_FALSE(is_inside_grid(VoxelIndex{-1, 7, 7}));
  CHECK_FALSE(is_inside_grid(VoxelIndex{7, 65536, 7}));
  CHECK_FALSE(is_inside_grid(VoxelIndex{7, 7, -1}));
}
