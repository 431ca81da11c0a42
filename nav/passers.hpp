// SPDX-License-Identifier: Apache-2.0
// Who passes by: what the camera measures right now where the map knows of nothing. A voxel that was free for long
// takes half a second of readings to become occupied, and nearer than the map trusts it never does, so people on their
// feet are not in the map. They are remembered here: until the camera has looked through the place again or for a
// while, which matters for whoever left the view at its side or came too near to be measured at all; and where he will
// be if he walks on, see passer_tracks.hpp.
#pragma once

#include <cstdint>

#include "hal/messages.hpp"
#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"
#include "nav/depth_scan.hpp"
#include "nav/moved_lately.hpp"
#include "nav/passer_tracks.hpp"
#include "nav/team_bodies.hpp"

namespace g3d::nav {

struct PassersConfig {
  double body_radius_m = 0.18;
  double hold_s = 5.0;   ///< somebody out of sight is taken to stand where he was last seen for so long
  double fresh_s = 1.2;  ///< while people are about, a look through a cell is worth so much
  PasserTracksConfig tracks;
};

class Passers {
 public:
  Passers(const CellGrid<CellState>& like, const PassersConfig& config);

  /// `scan`: of a frame that was taken here. Teammates who have said that they are there are none who pass by.
  /// Allocates nothing.
  void look(const DepthScan& scan, const CellGrid<CellState>& states, const MovedLately& moved,
            const hal::PlanarPose& T_world_base, hal::TimeNs now, const TeamBodies* teammates = nullptr);

  /// Somebody is, or was lately, in this cell, or is about to walk through it. May lie outside: then false.
  [[nodiscard]] bool is_there(Cell c, hal::TimeNs now) const {
    if (!until_.contains(c)) return false;
    return (until_.at(c) != 0 && until_.at(c) > tick(now)) ||
           tracks_.may_come(until_.centre_x_m(c), until_.centre_y_m(c), now);
  }

  /// When the camera last looked through there; 0: never, or it lies outside.
  [[nodiscard]] hal::TimeNs looked_ns(double x_m, double y_m) const {
    const Cell c = looked_.cell_of(x_m, y_m);
    return looked_.contains(c) && looked_.at(c) > 0 ? (static_cast<hal::TimeNs>(looked_.at(c)) - 1) * 100'000'000 : 0;
  }

  /// Nobody has looked through this cell lately, and somebody who is about could have walked there since.
  [[nodiscard]] bool may_have_come(Cell c, hal::TimeNs now) const {
    return looked_.contains(c) && tick(now) > looked_.at(c) + static_cast<std::uint32_t>(10.0 * config_.fresh_s) &&
           tracks_.may_have_come(looked_.centre_x_m(c), looked_.centre_y_m(c), now);
  }

 private:
  [[nodiscard]] static std::uint32_t tick(hal::TimeNs now) { return static_cast<std::uint32_t>(now / 100'000'000) + 1; }

  PassersConfig config_;
  CellGrid<std::uint32_t> until_;   ///< tick; 0: nobody
  CellGrid<std::uint32_t> looked_;  ///< tick of the last look through it; 0: never
  PasserTracks tracks_;
};

}  // namespace g3d::nav
