// SPDX-License-Identifier: Apache-2.0
#include "nav/move_field.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using namespace g3d::nav;
using mapper::submaps::ChainMove;

namespace {

CellGrid<CellState> grid() { return {0.05, -10.0, -10.0, 400, 400, CellState::unknown}; }
hal::Pose shift(double x_m, double y_m) { return hal::from_xyz_rpy(x_m, y_m, 0, 0, 0, 0); }

}  // namespace

TEST_CASE("a place moves as the newest way near it does") {
  MoveField field(grid());
  const ChainMove move({0, 100}, {shift(0.5, 0), shift(0, 0.25)});
  const std::vector<Trodden> way{{10, -5.0, 0.0}, {20, 3.2, 3.2}, {150, 3.3, 3.3}};
  field.compute(way, move);
  const Trodden old = field.moved({1, -5.2, 1.4});
  CHECK(old.x_m == Approx(-4.7));
  CHECK(old.y_m == Approx(1.4));
  CHECK(old.at_ns == 1);
  CHECK(field.moved({1, 3.9, 3.1}).y_m == Approx(3.35));  // gone over twice: the second time counts
  CHECK(field.moved({1, 5.1, 3.1}).y_m == Approx(3.35));
  CHECK(field.moved({1, 9.9, -9.9}).x_m == 9.9);  // nobody was ever near
  CHECK(field.moved({1, 900.0, 0.0}).x_m == 900.0);
}

TEST_CASE("cells of before are where they are now, and a second move starts from there") {
  MoveField field(grid());
  CellGrid<std::uint8_t> cells(0.05, -10.0, -10.0, 400, 400, 0);
  std::vector<std::uint8_t> scratch(cells.cells.size());
  const std::vector<Trodden> way{{10, 0.0, 0.0}};
  cells.at(cells.cell_of(1.02, 0.52)) = 9;
  cells.at(cells.cell_of(9.02, 9.02)) = 7;
  field.compute(way, ChainMove({0}, {shift(0.5, -0.1)}));
  field.resample(cells, scratch);
  CHECK(cells.at(cells.cell_of(1.52, 0.42)) == 9);
  CHECK(cells.at(cells.cell_of(1.02, 0.52)) == 0);
  CHECK(cells.at(cells.cell_of(9.02, 9.02)) == 0);  // too far from the way: forgotten
  field.compute(way, ChainMove({0}, {shift(-0.5, 0.1)}));
  field.resample(cells, scratch);
  CHECK(cells.at(cells.cell_of(1.02, 0.52)) == 9);
}

TEST_CASE("a grid whose cells do not fit into a metre is resampled without gaps") {
  const CellGrid<CellState> odd(0.08, -4.0, -4.0, 100, 100, CellState::unknown);
  MoveField field(odd);
  CellGrid<std::uint8_t> cells(0.08, -4.0, -4.0, 100, 100, 1);
  std::vector<std::uint8_t> scratch(cells.cells.size());
  field.compute(std::vector<Trodden>{{0, 0.0, 0.0}}, ChainMove());
  field.resample(cells, scratch);
  for (int y = 10; y < 90; ++y) {
    for (int x = 10; x < 90; ++x) {
      if (std::abs(x - 50) + std::abs(y - 50) < 55) REQUIRE(cells.at({x, y}) == 1);
    }
  }
}
