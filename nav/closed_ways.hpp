// SPDX-License-Identifier: Apache-2.0
// Places where the way was found closed: somebody stands in a door, and the map keeps him there until the camera looks
// again. Before the robot takes what lies behind for unreachable and goes home, it looks at each of them once more,
// from where it saw them closed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"
#include "nav/path_smoothing.hpp"

namespace g3d::nav {

struct ClosedWay {
  Waypoint at;
  hal::PlanarPose seen_from;  ///< turned towards it
  int looks = 0;              ///< since it was noted
};

class ClosedWays {
 public:
  static constexpr std::size_t kMost = 16;
  static constexpr int kMostLooks = 3;
  static constexpr double kSame_m = 0.8;

  ClosedWays() { ways_.reserve(kMost); }

  /// Places near one that is noted already are the same; when full, the oldest is forgotten.
  void note(const Waypoint& at, const hal::PlanarPose& T_world_base);
  /// The next one to look at, by position nearest to the robot among those looked at least: nullptr if there is none
  /// that is still closed and was not looked at often enough. Valid until the next call.
  [[nodiscard]] ClosedWay* next(const CellGrid<std::uint8_t>& cost, const hal::PlanarPose& T_world_base);
  [[nodiscard]] static bool is_closed(const Waypoint& at, const CellGrid<std::uint8_t>& cost);
  [[nodiscard]] std::size_t size() const { return ways_.size(); }

 private:
  std::vector<ClosedWay> ways_;
};

}  // namespace g3d::nav
