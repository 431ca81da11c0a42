// SPDX-License-Identifier: Apache-2.0
#include "nav/closed_way_check.hpp"

namespace g3d::nav {

std::optional<hal::PlanarPose> ClosedWayCheck::begin(const CellGrid<std::uint8_t>& cost,
                                                     const hal::PlanarPose& T_world_base) {
  ClosedWay* way = ways_.next(cost, T_world_base);
  if (way == nullptr) return std::nullopt;
  ++way->looks;
  checked_ = way->at;
  is_active_ = true;
  watch_until_ns_ = -1;
  return way->seen_from;
}

std::optional<ClosedWayCheck::Finding> ClosedWayCheck::step(const CellGrid<std::uint8_t>& cost, TimeNs now) {
  const bool is_open = !ClosedWays::is_closed(checked_, cost);
  if (!is_open && (watch_until_ns_ < 0 || now < watch_until_ns_)) return std::nullopt;
  is_active_ = false;
  return is_open ? Finding::open_now : Finding::still_closed;
}

}  // namespace g3d::nav
