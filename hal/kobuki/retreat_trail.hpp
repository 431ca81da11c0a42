// SPDX-License-Identifier: Apache-2.0
// Where the base has been: the only floor behind it of which it knows something, as the camera looks ahead. The body is
// round, so floor over which its centre went is free for it in any heading.
#pragma once

#include <array>
#include <cstddef>

#include "hal/twist.hpp"

namespace g3d::hal::kobuki {

/// One thread. Allocates nothing.
class RetreatTrail {
 public:
  /// The pose at which the base stands now, in a frame that does not jump.
  void update(const PlanarPose& T_world_base);
  /// Whether the base was where it would come by backing off a little from here.
  [[nodiscard]] bool leads_back_from(const PlanarPose& T_world_base) const;
  /// The frame has changed, or the base was carried.
  void forget() { size_ = 0; }

 private:
  static constexpr std::size_t kPlaces = 128;
  static constexpr double kSpacing_m = 0.015;    // so 1.9 m of way
  static constexpr double kLookBack_m = 0.05;    // farther than what one tick drives, nearer than what matters
  static constexpr double kTolerance_m = 0.015;  // sideways; 17 degrees off the trail's direction

  struct Place {
    double x_m = 0.0;
    double y_m = 0.0;
  };
  std::array<Place, kPlaces> places_{};  // a ring, `newest_` the last
  std::size_t size_ = 0;
  std::size_t newest_ = 0;
};

}  // namespace g3d::hal::kobuki
