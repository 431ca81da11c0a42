// SPDX-License-Identifier: Apache-2.0
#include "nav/moved_lately.hpp"

namespace g3d::nav {

MovedLately::MovedLately(const CellGrid<CellState>& like)
    : came_(like.resolution_m, like.origin_x_m, like.origin_y_m, like.columns, like.rows, 0) {}

void MovedLately::note(const GroundMap& ground, std::span<const std::uint32_t> changed, hal::TimeNs now) {
  for (const std::uint32_t index : changed) {
    if (ground.came_later(came_.cell(index))) came_.cells[index] = tick(now);
  }
}

}  // namespace g3d::nav
