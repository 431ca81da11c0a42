// SPDX-License-Identifier: Apache-2.0
// Who passes by: what the camera measures right now where the map knows of nothing. A voxel that was free for long
// takes half a second of readings to become occupied, and nearer than the map trusts it never does, so people on their
// feet are not in the map. They are remembered here: until the camera has looked through the place again or for a
// while, which matters for whoever left the view at its side or came too near to be measured at all.
#pragma once

#include <cstdint>

#include "hal/messages.hpp"
#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"
#include "nav/depth_scan.hpp"
#include "nav/moved_lately.hpp"

namespace g3d::nav {

struct PassersConfig {
  double body_radius_m = 0.18;
  double hold_s = 5.0;  ///< somebody out of sight is taken to stand where he was last seen for so long
};

class Passers {
 public:
  Passers(const CellGrid<CellState>& like, const PassersConfig& config);

  /// `scan`: of a frame that was taken here. Allocates nothing.
  void look(const DepthScan& scan, const CellGrid<CellState>& states, const MovedLately& moved,
            const hal::PlanarPose& T_world_base, hal::TimeNs now);

  /// Somebody is, or was lately, in this cell. May lie outside: then false.
  [[nodiscard]] bool is_there(Cell c, hal::TimeNs now) const {
    return until_.contains(c) && until_.at(c) != 0 && until_.at(c) > tick(now);
  }

 private:
  [[nodiscard]] static std::uint32_t tick(hal::TimeNs now) { return static_cast<std::uint32_t>(now / 100'000'000) + 1; }

  PassersConfig config_;
  CellGrid<std::uint32_t> until_;  ///< tick; 0: nobody
};

}  // namespace g3d::nav
