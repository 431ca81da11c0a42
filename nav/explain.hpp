// SPDX-License-Identifier: Apache-2.0
// Gives every frontier cluster that is left a reason, or calls it open. One thread; memory is sized by reset().
#pragma once

#include <cstdint>
#include <vector>

#include "nav/explained.hpp"
#include "nav/frontier.hpp"
#include "nav/set_aside.hpp"
#include "nav/view_tour.hpp"
#include "nav/viewpoints.hpp"
#include "nav/work_budget.hpp"

namespace g3d::nav {

class Explanation {
 public:
  void reset(std::size_t targets);
  /// The frontiers' clusters must be made. `any_open`: there are views worth taking, so what is seen from somewhere is
  /// open rather than too small.
  [[nodiscard]] FrontiersLeft explain(const CellGrid<CellState>& ground, const FrontierMap& frontiers,
                                      const Targets& targets, const SetAside& aside, const Viewpoints& places,
                                      double near_m, bool any_open);
  /// The first half of it in pieces: note_seen() until it says true, then name_reasons().
  void begin();
  [[nodiscard]] bool note_seen(const Targets& targets, const Viewpoints& places, WorkBudget& budget);
  [[nodiscard]] FrontiersLeft name_reasons(const CellGrid<CellState>& ground, const FrontierMap& frontiers,
                                           const Targets& targets, const SetAside& aside, double near_m,
                                           bool any_open) const;

 private:
  [[nodiscard]] bool has_room_to_look_from(const CellGrid<CellState>& ground, Cell frontier, double near_m) const;

  std::vector<std::uint32_t> seen_in_;  ///< per target: round in which a place was found that sees it
  std::uint32_t round_ = 0;
  std::size_t next_ = 0;  ///< of the useful places
};

}  // namespace g3d::nav
