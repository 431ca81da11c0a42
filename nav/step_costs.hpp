// SPDX-License-Identifier: Apache-2.0
// What one step on the cost grid costs, as integers: 50 per cell of free floor, up to five times as much right at the
// edge of what the body fits through (global_planner's neutral cost 50 and factor 0.8), diagonal steps sqrt(2) times.
// The cell that is entered counts. A diagonal step is possible only if both cells beside it are.
#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>

#include "nav/cell_grid.hpp"

namespace g3d::nav {

inline constexpr std::uint32_t kStraightCost = 50;  ///< one cell of free floor
inline constexpr std::uint32_t kDiagonalCost = 71;
inline constexpr std::uint32_t kMaxStepCost = 1024;  ///< no step costs more

struct StepOptions {
  bool allow_unknown = false;
  std::uint8_t unknown_as = 100;  ///< cost that unknown cells count as, 0..252
  /// When the robot finds itself where it would touch (an obstacle came near, or it stands tight), it may leave through
  /// inscribed cells from within this distance of the start. Obstacles themselves are never entered.
  int relief_cells = 6;
};

/// By cost of the cell that is entered; 0: not possible.
struct StepCosts {
  std::array<std::uint16_t, 256> straight{};
  std::array<std::uint16_t, 256> diagonal{};
};

[[nodiscard]] StepCosts make_step_costs(const StepOptions& options);
/// The same with inscribed cells passable at a high cost.
[[nodiscard]] StepCosts make_relief_costs(const StepOptions& options);

/// Direction d of a step leads to the neighbour (kStepX[d], kStepY[d]).
inline constexpr std::array<int, 8> kStepX{1, 0, -1, 0, 1, -1, -1, 1};
inline constexpr std::array<int, 8> kStepY{0, 1, 0, -1, 1, 1, -1, -1};

/// The steps that one search may take.
class StepRule {
 public:
  StepRule() = default;
  StepRule(const CellGrid<std::uint8_t>& cost, Cell start, const StepOptions& options);

  [[nodiscard]] bool can_stand(std::uint8_t cost) const { return normal_.straight[cost] != 0; }

  [[nodiscard]] bool gives_relief() const { return relief_cells_ >= 0; }

  /// visit(index of the neighbour, its x, its y, cost of the step, direction)
  template <typename Visit>
  void for_each_step(const CellGrid<std::uint8_t>& cost, std::uint32_t index, int x, int y, Visit&& visit) const {
    const bool near_start = std::abs(x - start_.x) <= relief_cells_ && std::abs(y - start_.y) <= relief_cells_;
    const StepCosts& steps = near_start ? relief_ : normal_;
    const std::uint8_t* here = cost.cells.data() + index;
    const int row = cost.columns;
    const std::uint32_t east = x + 1 < cost.columns ? steps.straight[here[1]] : 0;
    const std::uint32_t north = y + 1 < cost.rows ? steps.straight[here[row]] : 0;
    const std::uint32_t west = x > 0 ? steps.straight[here[-1]] : 0;
    const std::uint32_t south = y > 0 ? steps.straight[here[-row]] : 0;
    const auto step = [&](int direction, std::uint32_t price) {
      const auto d = static_cast<std::size_t>(direction);
      if (price == 0) return;
      visit(index + static_cast<std::uint32_t>(kStepY[d] * row + kStepX[d]), x + kStepX[d], y + kStepY[d], price,
            static_cast<std::uint32_t>(direction));
    };
    step(0, east);
    step(1, north);
    step(2, west);
    step(3, south);
    if (east != 0 && north != 0) step(4, steps.diagonal[here[row + 1]]);
    if (west != 0 && north != 0) step(5, steps.diagonal[here[row - 1]]);
    if (west != 0 && south != 0) step(6, steps.diagonal[here[-row - 1]]);
    if (east != 0 && south != 0) step(7, steps.diagonal[here[-row + 1]]);
  }

 private:
  StepCosts normal_;
  StepCosts relief_;
  Cell start_;
  int relief_cells_ = -1;  ///< -1: the start needs none
};

}  // namespace g3d::nav
