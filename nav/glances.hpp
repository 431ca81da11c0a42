// SPDX-License-Identifier: Apache-2.0
// What the camera has had in plain view on the way, and what stayed unknown all the same: black things, glass, nooks
// that nothing can be measured in. A target (a small square of frontier) that was glanced at from several places
// without becoming known is not worth as many looks of its own. One thread; memory is sized by reset().
#pragma once

#include <cstdint>
#include <vector>

#include "hal/messages.hpp"
#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"
#include "nav/view_gain.hpp"
#include "nav/view_tour.hpp"

namespace g3d::nav {

class Glances {
 public:
  void reset(const Targets& targets);
  /// Once per decision: where the robot is, and the map that holds what was seen until now. What is in view now and
  /// was already in view the last time, from where it can be measured well, stayed unknown.
  void look(const CellGrid<CellState>& ground, const Targets& targets, const ViewGain& camera,
            const hal::PlanarPose& T_world_base, hal::TimeNs now);
  /// From how many places, some decimetres apart, the target was seen so; at most 255.
  [[nodiscard]] int count(std::uint32_t target) const { return targets_[target].count; }

 private:
  struct Target {
    std::uint32_t round = 0;   ///< of the look that had it in view last,
    std::uint8_t rays = 0;     ///< by so many rays,
    bool was_in_view = false;  ///< and the look before had it, too
    std::int16_t x = 0;        ///< cell from which it was counted last
    std::int16_t y = 0;
    std::uint8_t count = 0;
  };

  std::vector<Target> targets_;
  PanoramaGain panorama_;
  std::uint32_t round_ = 0;
  hal::TimeNs looked_ns_ = 0;
};

}  // namespace g3d::nav
