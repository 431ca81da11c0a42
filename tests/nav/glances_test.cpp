// SPDX-License-Identifier: Apache-2.0
#include "nav/glances.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using namespace g3d::nav;

namespace {

/// Known floor of 6 x 4 m; something black of 0.4 x 0.8 m stays unknown in it.
struct Floor {
  Floor() : ground(0.05, 0.0, 0.0, 120, 80, CellState::free) {
    for (int y = 32; y < 48; ++y) {
      for (int x = 80; x < 88; ++x) ground.at({x, y}) = CellState::unknown;
    }
    targets.reset(ground.columns, ground.rows);
    glances.reset(targets);
  }
  void look(double x_m, double y_m, double heading_rad, double at_s) {
    glances.look(ground, targets, camera, {x_m, y_m, heading_rad}, static_cast<hal::TimeNs>(at_s * 1e9));
  }
  /// The frontier cell right before the black thing.
  [[nodiscard]] int count() const {
    return glances.count(targets.of_cell(static_cast<std::uint32_t>(ground.index({79, 40}))));
  }

  CellGrid<CellState> ground;
  Targets targets;
  ViewGain camera{ViewModel{}, 0.05};
  Glances glances;
};

}  // namespace

TEST_CASE("what stays unknown in plain view is counted once per place") {
  Floor floor;
  floor.look(2.5, 2.0, 0.0, 1.0);
  CHECK(floor.count() == 0);  // may just have come into view
  floor.look(2.5, 2.0, 0.0, 2.0);
  CHECK(floor.count() == 1);
  for (int s = 3; s < 20; ++s) floor.look(2.5, 2.1, 0.0, s);
  CHECK(floor.count() == 1);  // the same place
  floor.look(2.82, 2.12, 0.0, 20.0);
  floor.look(2.5, 1.8, 0.0, 21.0);
  CHECK(floor.count() == 3);
}

TEST_CASE("no glance is what is too near, too far, beside the view, hidden, or was in view for a moment only") {
  Floor floor;
  for (int s = 1; s < 5; ++s) floor.look(3.5, 2.0, 0.0, s);  // half a metre before it
  for (int s = 5; s < 9; ++s) floor.look(1.2, 2.0, 0.0, s);
  for (int s = 9; s < 13; ++s) floor.look(2.5, 2.0, 0.6, s);
  floor.look(2.5, 2.0, 0.0, 20.0);
  floor.look(2.5, 2.0, 0.0, 20.3);  // too soon
  floor.look(2.5, 2.0, 0.0, 30.0);  // long after
  floor.look(2.5, 2.0, 3.0, 31.0);
  floor.look(2.5, 2.0, 0.0, 32.0);
  CHECK(floor.count() == 0);
  for (int y = 20; y < 60; ++y) floor.ground.at({70, y}) = CellState::occupied;
  for (int s = 40; s < 45; ++s) floor.look(2.5, 2.0, 0.0, s);
  CHECK(floor.count() == 0);
  for (int y = 20; y < 60; ++y) floor.ground.at({70, y}) = CellState::free;
  for (int s = 50; s < 52; ++s) floor.look(2.5, 2.0, 0.0, s);
  CHECK(floor.count() == 1);
}

TEST_CASE("what is seen past an edge by a ray or two is not in plain view") {
  Floor floor;
  // All but 10 cm of it stands behind a wall.
  for (int y = 0; y < 80; ++y) {
    if (y < 39 || y > 40) floor.ground.at({78, y}) = CellState::occupied;
  }
  for (int s = 1; s < 5; ++s) floor.look(2.2, 2.0, 0.0, s);
  CHECK(floor.count() == 0);
}
