// SPDX-License-Identifier: Apache-2.0
#include "nav/closed_ways.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {

void ClosedWays::note(const Waypoint& at, const hal::PlanarPose& T_world_base) {
  for (const ClosedWay& way : ways_) {
    if (std::hypot(way.at.x_m - at.x_m, way.at.y_m - at.y_m) < kSame_m) return;
  }
  if (ways_.size() == kMost) ways_.erase(ways_.begin());
  hal::PlanarPose from = T_world_base;
  from.heading_rad = std::atan2(at.y_m - from.y_m, at.x_m - from.x_m);
  ways_.push_back({at, from, 0});
}

bool ClosedWays::is_closed(const Waypoint& at, const CellGrid<std::uint8_t>& cost) {
  const Cell c = cost.cell_of(at.x_m, at.y_m);
  return cost.contains(c) && cost.at(c) >= kInscribedCost && cost.at(c) != kUnknownCost;
}

ClosedWay* ClosedWays::next(const CellGrid<std::uint8_t>& cost, const hal::PlanarPose& T_world_base) {
  std::erase_if(ways_, [&](const ClosedWay& way) { return !is_closed(way.at, cost); });
  ClosedWay* best = nullptr;
  double best_m = 0.0;
  for (ClosedWay& way : ways_) {
    if (way.looks >= kMostLooks) continue;
    const double distance_m = std::hypot(way.seen_from.x_m - T_world_base.x_m, way.seen_from.y_m - T_world_base.y_m);
    if (best != nullptr && (way.looks > best->looks || (way.looks == best->looks && distance_m >= best_m))) continue;
    best = &way;
    best_m = distance_m;
  }
  return best;
}

}  // namespace g3d::nav
