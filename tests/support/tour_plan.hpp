// SPDX-License-Identifier: Apache-2.0
// A yardstick: the tour that one would plan with full knowledge of the building. Views (place and heading) are chosen
// by greedy set cover of what is observable, then ordered as a travelling salesman would (nearest neighbour, 2-opt,
// or-opt) by the time of driving and turning.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"

namespace g3d::tests {

inline constexpr int kTourBearings = 64;
inline constexpr int kTourWindow = 10;  ///< 56 of the camera's 57 degrees

/// What can be seen from a place by turning around: cells, and the bearing at which each is seen.
struct TourPlace {
  double x_m = 0.0;
  double y_m = 0.0;
  std::vector<std::uint32_t> cells;
  std::vector<std::uint8_t> bearing;
};

struct TourView {
  hal::PlanarPose pose;
  std::vector<std::uint32_t> cells;  ///< what it shows beyond the views chosen before it
};

/// Views that together with what is `covered` show that share of the cells that are `wanted`.
[[nodiscard]] std::vector<TourView> choose_views(const std::vector<TourPlace>& places,
                                                 const std::vector<std::uint8_t>& wanted,
                                                 std::vector<std::uint8_t> covered, double share);
/// Order in which to visit the poses, beginning with the first, the robot's. `costs` are the true ones.
[[nodiscard]] std::vector<std::size_t> order_views(const nav::CellGrid<std::uint8_t>& costs, double body_radius_m,
                                                   const std::vector<hal::PlanarPose>& poses);

}  // namespace g3d::tests
