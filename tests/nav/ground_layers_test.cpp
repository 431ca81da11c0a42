// SPDX-License-Identifier: Apache-2.0
#include "nav/ground_layers.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using namespace g3d::nav;

namespace {

// Lower and upper side of a range of layers.
std::pair<double, double> sides_m(const LayerRange& range, float resolution_m) {
  const double r_m = static_cast<double>(resolution_m);
  return {(range.first - 32768) * r_m, (range.last - 32767) * r_m};
}

}  // namespace

TEST_CASE("Layers at 5 cm: floor around 0, the body above, drops from 5 cm down") {
  const GroundLayers layers = ground_layers({0.05F}, {});
  CHECK(sides_m(layers.floor, 0.05F).first == Approx(-0.05));
  CHECK(sides_m(layers.floor, 0.05F).second == Approx(0.05));
  CHECK(sides_m(layers.band, 0.05F).first == Approx(0.05));
  CHECK(sides_m(layers.band, 0.05F).second == Approx(0.60));
  CHECK(sides_m(layers.air, 0.05F).second == Approx(0.45));
  CHECK(sides_m(layers.drop, 0.05F).first == Approx(-0.40));
  CHECK(sides_m(layers.drop, 0.05F).second == Approx(-0.05));
  CHECK(sides_m(layers.low, 0.05F).first == Approx(0.05));
  CHECK(sides_m(layers.low, 0.05F).second == Approx(0.10));
  CHECK(layers.first() == layers.drop.first);
}

TEST_CASE("At every resolution the floor is in the floor's layers and a step is in the band") {
  for (const float resolution_m : {0.005F, 0.01F, 0.02F, 0.025F, 0.03F, 0.05F, 0.1F}) {
    const mapper::Grid grid{resolution_m};
    const GroundLayers layers = ground_layers(grid, {});
    const double r_m = static_cast<double>(resolution_m);
    for (const float noise_m : {-0.009F, -0.004F, 0.0F, 0.004F}) CHECK(layers.floor.contains(grid.to_index(noise_m)));
    CHECK(layers.floor.contains(grid.to_index(0.014F)));  // a carpet's edge
    CHECK(layers.band.first == layers.floor.last + 1);
    CHECK(sides_m(layers.band, resolution_m).first >= 0.015 - 1e-6);
    CHECK(sides_m(layers.band, resolution_m).first < 0.015 + r_m - 1e-6);
    CHECK(layers.band.contains(grid.to_index(0.599F)));
    CHECK_FALSE(layers.band.contains(grid.to_index(0.601F + resolution_m)));
    CHECK(layers.drop.last < layers.floor.first);
    CHECK(layers.low.first == layers.band.first);
    CHECK(layers.low.last >= layers.low.first);
    CHECK(layers.low.last < layers.air.last);
    CHECK(sides_m(layers.drop, resolution_m).second <= -0.05 + 1e-6);
    CHECK(layers.drop.contains(grid.to_index(-0.17F)));  // the first step of a staircase down
  }
}

TEST_CASE("Ground cells come near to 5 cm and tile a block") {
  CHECK(voxels_per_ground_cell({0.05F}) == 1);
  CHECK(voxels_per_ground_cell({0.1F}) == 1);
  CHECK(voxels_per_ground_cell({0.04F}) == 1);
  CHECK(voxels_per_ground_cell({0.03F}) == 2);
  CHECK(voxels_per_ground_cell({0.02F}) == 2);
  CHECK(voxels_per_ground_cell({0.01F}) == 4);
  CHECK(voxels_per_ground_cell({0.005F}) == 8);
  CHECK(voxels_per_ground_cell({0.002F}) == 8);
}
