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
  const hal::PlanFrame& frame = observable_->frame;
  std::size_t known = 0;
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      const hal::SeenCell seen = observable_->cells[frame.index(column, row)];
      if (seen == hal::SeenCell::not_observable) continue;
      const Cell c = ground.cell_of(frame.x_m(column), frame.y_m(row));
      if (!ground.contains(c)) continue;
      const bool is_known =
          seen == hal::SeenCell::free ? ground.at(c) != CellState::unknown : has_obstacle_around(ground, c);
      known += is_known ? 1 : 0;
    }
  }
  const std::size_t all = observable_->count();
  return all == 0 ? 1.0 : static_cast<double>(known) / static_cast<double>(all);
}

}  // namespace g3d::nav
