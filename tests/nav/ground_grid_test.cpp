// SPDX-License-Identifier: Apache-2.0
#include "nav/ground_grid.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using mapper::State;

TEST_CASE("Every ground cell says what its column says") {
  const auto map = tests::random_map(61, 300, 0.1F);
  const nav::HeightBand band{-0.6F, 0.7F};
  const nav::GroundGrid ground = nav::project_to_ground(*map, band);
  REQUIRE(ground.columns > 10);
  std::uint64_t wrong = 0;
  std::uint64_t seen = 0;
  const int x_low = static_cast<int>(std::lround(ground.origin_x_m / 0.1)) + 32768;
  const int y_low = static_cast<int>(std::lround(ground.origin_y_m / 0.1)) + 32768;
  const int step_x = std::max(1, ground.columns / 300);  // far blocks make the grid wide: look at a part of it
  const int step_y = std::max(1, ground.rows / 300);
  for (int row = 0; row < ground.rows; row += step_y) {
    for (int column = 0; column < ground.columns; column += step_x) {
      State expected = State::unknown;
      for (int z = 32760; z <= 32776; ++z) {
        const double centre_m = map->grid().centre_m(z);
        if (centre_m < -0.6 || centre_m > 0.7) continue;
        const State state = mapper::state_of(map->at(mapper::VoxelIndex{x_low + column, y_low + row, z}));
        if (state == State::occupied || (state == State::free && expected == State::unknown)) expected = state;
      }
      wrong += ground.at(column, row) != expected ? 1 : 0;
      seen += expected != State::unknown ? 1 : 0;
    }
  }
  CHECK(wrong == 0);
  CHECK(seen > 0);
}

TEST_CASE("A room projects to walls, furniture and free floor") {
  const auto map = tests::furnished_room(0.1F);
  const nav::GroundGrid ground = nav::project_to_ground(*map);
  const auto at = [&](double x, double y) {
    return ground.at(static_cast<int>(std::floor((x - ground.origin_x_m) / 0.1)),
                     static_cast<int>(std::floor((y - ground.origin_y_m) / 0.1)));
  };
  CHECK(at(0.0, 0.0) == State::occupied);  // under the table top: 0.70 m is in the band
  CHECK(at(-1.5, 0.0) == State::free);
  CHECK(at(-3.05, 1.5) == State::occupied);  // wall
  CHECK(at(3.05, 1.2) == State::free);       // the doorway
  CHECK(at(-9.0, 0.0) == State::unknown);
  const nav::GroundGrid low = nav::project_to_ground(*map, {0.1F, 0.5F});
  const int column = static_cast<int>(std::floor((0.0 - low.origin_x_m) / 0.1));
  const int row = static_cast<int>(std::floor((0.0 - low.origin_y_m) / 0.1));
  CHECK(low.at(column, row) == State::free);  // a lower robot drives under the table
}

TEST_CASE("A map with nothing in the band gives an empty grid") {
  const auto map = tests::furnished_room(0.1F);
  const nav::GroundGrid ground = nav::project_to_ground(*map, {50.0F, 51.0F});
  CHECK(ground.columns == 0);
  CHECK(ground.cells.empty());
  CHECK(ground.at(0, 0) == State::unknown);
}

TEST_CASE("A stray voxel at the end of the world does not make a giant of the grid") {
  const auto map = tests::furnished_room(0.1F);
  mapper::BlockValues values;
  values.fill(32);
  REQUIRE(map->write_block(mapper::block_of({65528, 16, 32776}), values));
  const nav::GroundGrid ground = nav::project_to_ground(*map);
  CHECK(ground.columns == nav::kMaxGroundSide_cells);
  CHECK(ground.rows == nav::kMaxGroundSide_cells);
  const int column = static_cast<int>(std::floor((-3.05 - ground.origin_x_m) / 0.1));
  const int row = static_cast<int>(std::floor((1.5 - ground.origin_y_m) / 0.1));
  CHECK(ground.at(column, row) == State::occupied);  // the room is still there
}
