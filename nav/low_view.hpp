// SPDX-License-Identifier: Apache-2.0
// Where a level camera has looked low enough. It sees the floor only from some distance on; a little nearer it still
// sees down to the height of a shoe, and right before the robot only that the air above is clear. Cells seen at least
// that low are driven over at full speed, the others at a creep.
//
//   camera o────────────
//      h   │ ` .  down
//          │      ` .          low_m: what is lower than `hidden` stays out of sight
//   ───────┴──────────`─.──────
//          0    low_m   floor
#pragma once

#include <cstdint>

#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"
#include "nav/depth_scan.hpp"
#include "nav/move_field.hpp"

namespace g3d::nav {

struct LowViewConfig {
  double forward_m = 0.0;  ///< camera in front of the base's origin
  double height_m = 0.5;   ///< camera above the floor
  double down_rad = 0.43;  ///< lower edge of the image below the horizon: half of 49 degrees for a level camera
  double view_rad = 0.9;   ///< horizontal, a little less than all of it: poses and frames are never quite of one time
  double hidden_m = 0.15;  ///< what is lower may stay unseen
};

class LowView {
 public:
  /// For grids of this geometry.
  LowView(const CellGrid<CellState>& like, const LowViewConfig& config);

  /// A frame was taken here: marks what lies in view between low_m() and where the floor itself is seen, over free
  /// cells alone. With `scan`, of that frame, only as far as the floor is measured: something black that stands on it
  /// gives no reading, and then nobody has looked low.
  void look(const CellGrid<CellState>& states, const hal::PlanarPose& T_world_base, const DepthScan* scan = nullptr);

  /// The map has moved. `scratch`: as many cells.
  void move(const MoveField& field, std::vector<std::uint8_t>& scratch) { field.resample(seen_, scratch); }
  [[nodiscard]] bool is_seen(Cell c) const { return seen_.contains(c) && seen_.at(c) != 0; }
  [[nodiscard]] double low_m() const { return low_m_; }

 private:
  void walk(const CellGrid<CellState>& states, const hal::PlanarPose& T_world_base, double bearing_rad, double reach_m);

  LowViewConfig config_;
  double low_m_;
  double far_m_;
  CellGrid<std::uint8_t> seen_;
};

}  // namespace g3d::nav
