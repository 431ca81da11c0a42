// SPDX-License-Identifier: Apache-2.0
#include "nav/coverage.hpp"

namespace g3d::nav {
namespace {

bool has_obstacle_around(const CellGrid<CellState>& ground, Cell c) {
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const Cell n{c.x + dx, c.y + dy};
      if (ground.contains(n) && ground.at(n) == CellState::occupied) return true;
    }
  }
  return false;
}

}  // namespace

double CoverageMeter::fraction(const CellGrid<CellState>& ground) const {
  return hal::coverage(*observable_,
                       [&](double x_m, double y_m, hal::SeenCell seen) { return is_known(ground, x_m, y_m, seen); });
}

bool CoverageMeter::is_known(const CellGrid<CellState>& ground, double x_m, double y_m, hal::SeenCell seen) {
  const Cell c = ground.cell_of(x_m, y_m);
  if (!ground.contains(c)) return false;
  return seen == hal::SeenCell::free ? ground.at(c) != CellState::unknown : has_obstacle_around(ground, c);
}

}  // namespace g3d::nav
