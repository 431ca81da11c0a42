// SPDX-License-Identifier: Apache-2.0
// The costs that paths are planned by where teammates stand about: those of the floor, and nothing leads through a
// body. Kept as a copy, so that the costs themselves stay what the building's are. One thread. Sized at construction.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "nav/cell_grid.hpp"
#include "nav/teammates.hpp"

namespace g3d::nav {

class TeamCost {
 public:
  struct Body {
    double x_m = 0.0, y_m = 0.0;
    double radius_m = 0.0;  ///< in which no centre of a robot may be
  };

  explicit TeamCost(const CellGrid<std::uint8_t>& like);

  /// The floor's costs changed here.
  void note_changed(const CellGrid<std::uint8_t>& cost, std::span<const std::uint32_t> cells);
  /// These bodies and no others stand there now; at most kMostTeammates. Cells around them cost more, too.
  void stand(const CellGrid<std::uint8_t>& cost, std::span<const Body> bodies);
  /// Nobody stands anywhere.
  [[nodiscard]] bool empty() const { return body_count_ == 0; }
  /// As of the last note_changed() and stand(). Costs nothing to keep until the first body stands.
  [[nodiscard]] const CellGrid<std::uint8_t>& cost() const { return cost_; }

 private:
  void stamp(const CellGrid<std::uint8_t>& cost);

  CellGrid<std::uint8_t> cost_;
  bool is_copied_ = false;
  std::array<Body, kMostTeammates> bodies_{};
  std::size_t body_count_ = 0;
  std::vector<std::uint32_t> stamped_;
};

}  // namespace g3d::nav
