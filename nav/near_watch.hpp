// SPDX-License-Identifier: Apache-2.0
// Somebody stands right before the robot: the camera measures nothing so near, and the map still says that the floor
// there is free. What gives him away is that the floor behind him, which fills the lowest rows of the image, is not
// measured either. Over a wide enough part of the image, and where the map knows of nothing near that explains it, the
// cells before the robot become suspect for a while. The same catches black furniture, which is never measured.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "hal/messages.hpp"
#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"
#include "nav/moved_lately.hpp"
#include "nav/team_bodies.hpp"

namespace g3d::nav {

using hal::TimeNs;

struct NearWatchConfig {
  double body_radius_m = 0.18;
  double forward_m = 0.0;     ///< camera in front of the base's origin
  double near_m = 0.8;        ///< nearer readings are not trusted
  double explained_m = 0.85;  ///< an obstacle in the map at most this far off hides the floor
  double lowest_rows = 0.15;  ///< of the image: where a free floor is measured
  double seen_share = 0.2;    ///< of these pixels in a sector, if the floor is free
  int least_sectors = 5;      ///< beside each other; narrower gaps are the shadows that near things throw
  int least_at_edge = 3;      ///< at the image's edge, where only a part is in view
  double hold_s = 2.5;        ///< a suspicion that is not repeated ends
};

class NearWatch {
 public:
  static constexpr int kSectors = 16;

  /// For grids of this geometry.
  NearWatch(const CellGrid<CellState>& like, const NearWatchConfig& config);

  /// A frame was taken here. Teammates who have said that they are there are a reason, too. Allocates nothing.
  void look(const hal::Frame& frame, const hal::CameraModel& camera, const CellGrid<CellState>& states,
            const MovedLately& moved, const hal::PlanarPose& T_world_base, TimeNs now,
            const TeamBodies* teammates = nullptr);

  [[nodiscard]] bool is_suspect(Cell c, TimeNs now) const {
    return until_.contains(c) && until_.at(c) != 0 && until_.at(c) > tick(now);
  }
  /// Where the last frame's suspicious sectors pass this distance from the base: visit(x_m, y_m), world frame.
  template <typename Visit>
  void for_suspicious(double distance_m, Visit visit) const {
    for (std::size_t i = 0; i < kSectors; ++i) {
      if (!is_suspicious_[i]) continue;
      visit(last_pose_.x_m + distance_m * std::cos(bearings_rad_[i]),
            last_pose_.y_m + distance_m * std::sin(bearings_rad_[i]));
    }
  }
  /// Sectors from left to right in which the last frame had no floor and the map no reason.
  [[nodiscard]] const std::array<bool, kSectors>& sectors() const { return is_suspicious_; }

 private:
  /// Tenths of a second: a grid of them is half as large.
  [[nodiscard]] static std::uint32_t tick(TimeNs now) { return static_cast<std::uint32_t>(now / 100'000'000) + 1; }
  [[nodiscard]] bool sees_floor(const hal::Frame& frame, const hal::CameraModel& camera, int sector) const;
  [[nodiscard]] static double bearing_rad(const hal::PlanarPose& T_world_base, const hal::CameraModel& camera,
                                          int sector, double part);
  template <typename Visit>
  void walk(const hal::PlanarPose& T_world_base, const hal::CameraModel& camera, int sector, double part, double from_m,
            double to_m, Visit visit) const;

  NearWatchConfig config_;
  CellGrid<std::uint32_t> until_;  ///< tick; 0: never was suspect
  std::array<bool, kSectors> is_suspicious_{};
  std::array<double, kSectors> bearings_rad_{};  ///< world frame
  hal::PlanarPose last_pose_;
};

}  // namespace g3d::nav
