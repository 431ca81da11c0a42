// SPDX-License-Identifier: Apache-2.0
// Where who passes by is and goes. While somebody is in view his velocity is estimated; once he has left the view at
// its side, or has come too near to be measured, he is taken to walk on straight for a while, or to stand if he stood.
// Without that a robot that drives while somebody comes at a constant bearing from where it does not look meets him: he
// was where nobody is any more. And he is a body, of which the camera measures the front: who is gone around is as deep
// as wide. What was never seen to walk is none of ours.
// Prediction with constant velocity, estimated by an alpha-beta filter (Bar-Shalom, Li, Kirubarajan: Estimation with
// Applications to Tracking and Navigation, section 6.5).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/messages.hpp"
#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"
#include "nav/depth_scan.hpp"
#include "nav/moved_lately.hpp"

namespace g3d::nav {

struct PasserTracksConfig {
  double radius_m = 0.28;         ///< of somebody on his feet, arms included
  double depth_m = 0.14;          ///< his middle lies so far behind what is measured of him
  double doubt_mps = 0.05;        ///< so much the predicted place grows
  double ahead_s = 1.5;           ///< where he will be so soon is taken as well
  double walks_on_s = 6.0;        ///< after the last sight
  double known_after_s = 0.4;     ///< in view, until his velocity is believed
  double least_mps = 0.25;        ///< slower: he stands, or it is none who walks
  double most_mps = 2.0;          ///< faster: the readings were not of one thing
  double gate_m = 0.5;            ///< farther from where he should be it is somebody else
  double surely_walked_m = 0.25;  ///< noise that slides along a wall gets less far
  double about_s = 15.0;          ///< after the last sight he is still thought to be somewhere near
  double roams_mps = 1.2;         ///< and to have gone anywhere so fast
};

class PasserTracks {
 public:
  static constexpr std::size_t kMost = 8;

  explicit PasserTracks(const PasserTracksConfig& config) : config_(config) {}

  using Rays = std::array<bool, DepthScan::kRays>;

  /// `is_somebody[i]`: what ray i meets is not in the map; `came_lately[i]`: it is, but not for long: who stops becomes
  /// a part of it. `T_world_base`: where the scan was taken. Allocates nothing.
  void look(const DepthScan& scan, const Rays& is_somebody, const Rays& came_lately, const CellGrid<CellState>& states,
            const MovedLately& moved, const hal::PlanarPose& T_world_base, hal::TimeNs now);

  /// Somebody stands or walks here; or, if he is out of sight, will be here within `ahead_s`.
  [[nodiscard]] bool may_come(double x_m, double y_m, hal::TimeNs now) const;
  /// Somebody who has walked and is out of sight could have got here by now, whichever way he took.
  [[nodiscard]] bool may_have_come(double x_m, double y_m, hal::TimeNs now) const;

 private:
  struct Track {
    double x_m = 0.0, y_m = 0.0;  ///< world frame, at seen_ns
    double vx_mps = 0.0, vy_mps = 0.0;
    hal::TimeNs first_ns = 0;
    hal::TimeNs seen_ns = 0;
    hal::TimeNs ends_ns = 0;  ///< 0: no track
    bool is_in_view = false;
    bool has_walked = false;
    double first_x_m = 0.0, first_y_m = 0.0;
    bool is_sure = false;  ///< he has walked some way
  };
  /// Where he is now, and how fast: who stands does not creep away while nobody looks.
  struct Guess {
    double x_m, y_m;
    double vx_mps, vy_mps;
  };
  struct Sight {
    double x_m, y_m;
    bool is_whole;  ///< the image's edge cuts nothing off
  };
  static constexpr std::size_t kMostSights = 16;

  [[nodiscard]] std::size_t gather(const DepthScan& scan, const Rays& wanted, const hal::PlanarPose& T_world_base,
                                   std::array<Sight, kMostSights>& sights) const;
  [[nodiscard]] Track* nearest(const Sight& sight, bool must_have_walked, hal::TimeNs now);
  [[nodiscard]] Track& oldest();
  void follow(Track& track, const Sight& sight, hal::TimeNs now) const;
  [[nodiscard]] bool is_walking(const Track& track) const;
  [[nodiscard]] Guess guess(const Track& track, hal::TimeNs now) const;
  [[nodiscard]] bool is_looked_through(const Track& track, const DepthScan& scan, const hal::PlanarPose& T_world_base,
                                       hal::TimeNs now) const;
  [[nodiscard]] bool has_way(const Track& track, const CellGrid<CellState>& states, const MovedLately& moved,
                             hal::TimeNs now) const;

  PasserTracksConfig config_;
  std::array<Track, kMost> tracks_{};
};

}  // namespace g3d::nav
