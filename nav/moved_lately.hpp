// SPDX-License-Identifier: Apache-2.0
// Where something came to stand lately on floor that had been seen free: it moves, and the map's cell says where it
// was, not where it is.
#pragma once

#include <cstdint>
#include <span>

#include "hal/messages.hpp"
#include "nav/ground_map.hpp"

namespace g3d::nav {

class MovedLately {
 public:
  static constexpr double kLately_s = 30.0;

  /// For the ground map's grid, of which nothing is known yet.
  explicit MovedLately(const CellGrid<CellState>& like);

  /// The ground map has changed these cells. Allocates nothing.
  void note(const GroundMap& ground, std::span<const std::uint32_t> changed, hal::TimeNs now);
  /// Whether the obstacle in this cell came there lately. May lie outside: then false.
  [[nodiscard]] bool is_new(Cell c, hal::TimeNs now) const {
    return came_.contains(c) && came_.at(c) != 0 && tick(now) - came_.at(c) < kLately_s * kTicksPerSecond;
  }

 private:
  static constexpr double kTicksPerSecond = 10.0;
  [[nodiscard]] static std::uint32_t tick(hal::TimeNs now) { return static_cast<std::uint32_t>(now / 100'000'000) + 1; }

  CellGrid<std::uint32_t> came_;  ///< tick; 0: never
};

}  // namespace g3d::nav
