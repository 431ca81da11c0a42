// SPDX-License-Identifier: Apache-2.0
// The look at one closed way after the other, before the robot goes home: drive to where it was seen closed, watch it
// for a while, and find it open or closed. What was found closed on the way is noted here.
#pragma once

#include <cstdint>
#include <optional>

#include "hal/messages.hpp"
#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"
#include "nav/closed_ways.hpp"

namespace g3d::nav {

using hal::TimeNs;

class ClosedWayCheck {
 public:
  enum class Finding : std::uint8_t { open_now, still_closed };

  /// `watch_s`: how long it watches until it takes a way for closed.
  explicit ClosedWayCheck(double watch_s) : watch_ns_(static_cast<TimeNs>(watch_s * 1e9)) {}

  void note(const Waypoint& at, const hal::PlanarPose& T_world_base) { ways_.note(at, T_world_base); }
  /// Begins with the next one: where to drive to. None: there is nothing (more) to look at.
  [[nodiscard]] std::optional<hal::PlanarPose> begin(const CellGrid<std::uint8_t>& cost,
                                                     const hal::PlanarPose& T_world_base);
  /// It stands there: the watch begins.
  void watch(TimeNs now) { watch_until_ns_ = now + watch_ns_; }
  /// Once per step while active. A finding ends the check.
  [[nodiscard]] std::optional<Finding> step(const CellGrid<std::uint8_t>& cost, TimeNs now);
  void end() { is_active_ = false; }
  [[nodiscard]] bool is_active() const { return is_active_; }

 private:
  TimeNs watch_ns_;
  ClosedWays ways_;
  bool is_active_ = false;
  Waypoint checked_;
  TimeNs watch_until_ns_ = -1;  ///< -1: still on the way there
};

}  // namespace g3d::nav
