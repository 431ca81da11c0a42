// SPDX-License-Identifier: Apache-2.0
#include "net/block_grid.hpp"

#include <catch2/catch.hpp>
#include <set>

#include "mapper/morton.hpp"

using namespace g3d;
using namespace g3d::net;

TEST_CASE("The order of rows names every voxel once, and halves are halves of it") {
  std::set<std::uint16_t> in_block;
  std::set<std::uint16_t> in_grid;
  for (std::size_t i = 0; i < kGridOrder.block.size(); ++i) {
    in_block.insert(kGridOrder.block[i]);
    in_grid.insert(kGridOrder.grid[i]);
    REQUIRE((i < 256) == (kGridOrder.block[i] < 256));
    const mapper::VoxelIndex v = mapper::decode(kGridOrder.block[i]);
    REQUIRE(kGridOrder.grid[i] == grid_place(v.x, v.y, v.z));
    REQUIRE(kGridOrder.grid[i] < kGridPlaces);
  }
  CHECK(in_block.size() == 512);
  CHECK(in_grid.size() == 512);
  CHECK(places_of(Part::whole).count() == 512);
  CHECK(places_of(Part::low_half).end == places_of(Part::high_half).begin);
  CHECK(places_of(Part::high_half).end == 512);
}

TEST_CASE("All that touches a voxel from before lies in the grid, at an earlier place or at its border") {
  for (const std::uint16_t place : kGridOrder.grid) {
    for (const int step : {1, kRow - 1, kRow, kRow + 1, kLayer - kRow - 1, kLayer, kLayer + kRow + 1}) {
      REQUIRE(place >= step);
    }
  }
}
