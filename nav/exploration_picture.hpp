// SPDX-License-Identifier: Apache-2.0
// One picture of an exploration: the ground map with the way that was driven, home and the frontiers that are left, and
// below it the coverage over time. Way and curve go through the same colours, so that one sees what was seen where.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "hal/geometry.hpp"
#include "hal/result.hpp"
#include "hal/twist.hpp"
#include "nav/canvas.hpp"
#include "nav/cell_grid.hpp"
#include "nav/mission_report.hpp"

namespace g3d::nav {

struct ExplorationPicture {
  const CellGrid<CellState>* ground = nullptr;
  std::span<const std::uint32_t> frontier_cells;  ///< indices of ground cells
  std::span<const hal::Pose> trajectory;          ///< evenly spaced in time
  hal::PlanarPose home;
  std::span<const CoverageSample> coverage;  ///< empty: nobody knows, and there is no curve
  double time_s = 0.0;                       ///< of the whole trajectory
  std::string title;                         ///< lower case, digits and . , : % - /
};

/// x to the right, y up. A ground map of which nothing is known gives the frame alone.
[[nodiscard]] Canvas draw_exploration(const ExplorationPicture& picture);
/// As PNG, by temporary file and rename. Gives the bytes written.
[[nodiscard]] hal::Result<std::uint64_t> write_exploration_picture(const ExplorationPicture& picture,
                                                                   const std::string& path);

}  // namespace g3d::nav
