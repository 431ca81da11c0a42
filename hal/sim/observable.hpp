// SPDX-License-Identifier: Apache-2.0
// How much of a world there is to be seen. A cell of the 5 cm floor plan is observable if a camera sees it from at
// least three poses of a 0.2 m lattice that the robot can reach: over a distance of 0.8 to 3.5 m, turned towards it,
// within the image's height, through whatever is open in between. A wall cell is seen where a ray of the camera ends on
// it within the height band of the robot's body, a free one where a ray passes through it in that band. What is black
// is never seen, glass is looked through. Coverage = known cells / observable cells.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hal/result.hpp"
#include "hal/sim/reach.hpp"
#include "hal/sim/world.hpp"
#include "hal/twist.hpp"

namespace g3d::hal {

struct ObservableOptions {
  ReachOptions reach;
  double cell_m = 0.05;
  int lattice_cells = 4;  ///< 0.2 m
  double near_m = 0.8;
  double far_m = 3.5;
  double camera_height_m = 0.5;
  double half_height_tan = 240.0 / 525.0;  ///< half the image's height over the focal length; the axis is level
  HeightSlice band{0.05, 0.60};
  int poses_needed = 3;
};

enum class SeenCell : std::uint8_t { not_observable, free, wall };

struct Observable {
  PlanFrame frame;
  std::vector<SeenCell> cells;          ///< row-major
  std::vector<std::uint8_t> reachable;  ///< 1 where the robot's centre can be
  std::size_t free_count = 0;
  std::size_t wall_count = 0;
  std::size_t reachable_count = 0;

  [[nodiscard]] std::size_t count() const { return free_count + wall_count; }
};

/// What can be seen by a robot that begins at any of `starts`. People and robots are left out.
[[nodiscard]] Result<Observable> find_observable(const World& world, std::span<const PlanarPose> starts,
                                                 const ObservableOptions& options = {});

/// The share of what is observable that is_known(x_m, y_m, SeenCell), asked for the middle of each such cell; 1 if
/// nothing is.
template <typename IsKnown>
[[nodiscard]] double coverage(const Observable& observable, const IsKnown& is_known) {
  std::size_t known = 0;
  for (int row = 0; row < observable.frame.rows; ++row) {
    for (int column = 0; column < observable.frame.columns; ++column) {
      const SeenCell seen = observable.cells[observable.frame.index(column, row)];
      if (seen == SeenCell::not_observable) continue;
      known += is_known(observable.frame.x_m(column), observable.frame.y_m(row), seen) ? 1 : 0;
    }
  }
  return observable.count() == 0 ? 1.0 : static_cast<double>(known) / static_cast<double>(observable.count());
}

}  // namespace g3d::hal
