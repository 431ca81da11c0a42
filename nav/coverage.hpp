// SPDX-License-Identifier: Apache-2.0
// How much of what can be seen the robot knows: coverage = known cells / observable cells. A free cell is known if the
// ground map says anything about it; a wall cell if the map has an obstacle there or beside it, as a surface on the
// edge of two cells may be measured in either.
#pragma once

#include "hal/sim/observable.hpp"
#include "nav/cell_grid.hpp"

namespace g3d::nav {

class CoverageMeter {
 public:
  /// `observable` outlives the meter.
  explicit CoverageMeter(const hal::Observable& observable) : observable_(&observable) {}

  /// Whether the map knows what can be seen at this place.
  [[nodiscard]] static bool is_known(const CellGrid<CellState>& ground, double x_m, double y_m, hal::SeenCell seen);
  /// 0..1; 1 if there is nothing to be seen.
  [[nodiscard]] double fraction(const CellGrid<CellState>& ground) const;

 private:
  const hal::Observable* observable_;
};

}  // namespace g3d::nav
