// SPDX-License-Identifier: Apache-2.0
#include "nav/coverage.hpp"

#include <catch2/catch.hpp>
#include <vector>

using namespace g3d;
using hal::SeenCell;
using nav::Cell;
using nav::CellState;

namespace {

/// Four free cells and two wall cells in a frame of 8 x 4 that begins at cell (-2, 3).
struct Truth {
  Truth() {
    observable.frame = {0.05, -2, 3, 8, 4};
    observable.cells.assign(observable.frame.count(), SeenCell::not_observable);
    for (int column = 1; column <= 4; ++column) set(column, 1, SeenCell::free);
    set(5, 1, SeenCell::wall);
    set(6, 3, SeenCell::wall);
    observable.free_count = 4;
    observable.wall_count = 2;
  }
  void set(int column, int row, SeenCell seen) { observable.cells[observable.frame.index(column, row)] = seen; }
  /// The ground's cell under a cell of the frame.
  [[nodiscard]] Cell at(int column, int row) const {
    return ground.cell_of(observable.frame.x_m(column), observable.frame.y_m(row));
  }
  hal::Observable observable;
  nav::CellGrid<CellState> ground{0.05, -1.0, -1.0, 40, 60, CellState::unknown};
};

}  // namespace

TEST_CASE("nothing known is 0, nothing to be seen is 1", "[nav][coverage]") {
  const Truth truth;
  CHECK(nav::CoverageMeter(truth.observable).fraction(truth.ground) == 0.0);
  hal::Observable empty;
  CHECK(nav::CoverageMeter(empty).fraction(truth.ground) == 1.0);
}

TEST_CASE("a free cell counts as soon as anything is known of it, others do not count", "[nav][coverage]") {
  Truth truth;
  const nav::CoverageMeter meter(truth.observable);
  truth.ground.at(truth.at(1, 1)) = CellState::free;
  CHECK(meter.fraction(truth.ground) == Approx(1.0 / 6.0));
  truth.ground.at(truth.at(2, 1)) = CellState::occupied;
  CHECK(meter.fraction(truth.ground) == Approx(2.0 / 6.0));
  truth.ground.at(truth.at(7, 0)) = CellState::free;  // not observable
  CHECK(meter.fraction(truth.ground) == Approx(2.0 / 6.0));
}

TEST_CASE("a wall cell needs an obstacle there or beside it", "[nav][coverage]") {
  Truth truth;
  const nav::CoverageMeter meter(truth.observable);
  truth.ground.at(truth.at(6, 3)) = CellState::free;
  CHECK(meter.fraction(truth.ground) == 0.0);
  truth.ground.at(truth.at(7, 2)) = CellState::occupied;  // across the corner
  CHECK(meter.fraction(truth.ground) == Approx(1.0 / 6.0));
  truth.ground.at(truth.at(3, 3)) = CellState::occupied;  // two beside the other
  CHECK(meter.fraction(truth.ground) == Approx(1.0 / 6.0));
}

TEST_CASE("what lies beyond the ground map is unknown", "[nav][coverage]") {
  const Truth truth;
  const nav::CellGrid<CellState> small(0.05, -0.05, 0.15, 3, 3, CellState::free);
  // Of the row of free cells, columns 1 to 3 lie on it.
  CHECK(nav::CoverageMeter(truth.observable).fraction(small) == Approx(3.0 / 6.0));
  const nav::CellGrid<CellState> elsewhere(0.05, 50.0, 50.0, 10, 10, CellState::free);
  CHECK(nav::CoverageMeter(truth.observable).fraction(elsewhere) == 0.0);
}
