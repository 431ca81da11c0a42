// SPDX-License-Identifier: Apache-2.0
// What one step on the cost grid costs, as integers: 50 per cell of free floor, up to five times as much right at the
// edge of what the body fits through (global_planner's neutral cost 50 and factor 0.8), diagonal steps sqrt(2) times.
// The cell that is entered counts. A diagonal step is possible only if both cells beside it are.
#pragma once

#include <array>
#include <cstdint>

namespace g3d::nav {

inline constexpr std::uint32_t kStraightCost = 50;  ///< one cell of free floor
inline constexpr std::uint32_t kDiagonalCost = 71;
inline constexpr std::uint32_t kMaxStepCost = 2048;  ///< no step costs more

struct StepOptions {
  bool allow_unknown = false;
  std::uint8_t unknown_as = 100;  ///< cost that unknown cells count as, 0..252
  /// When the robot finds itself where it would touch (an obstacle came near, or it stands tight), it may leave through
  /// inscribed cells within this distance of the start. Obstacles themselves are never entered.
  int relief_cells = 6;
};

struct StepCosts {
  std::array<std::uint16_t, 256> straight{};  ///< by cost of the cell entered; 0: not possible
  std::array<std::uint16_t, 256> diagonal{};
};

[[nodiscard]] StepCosts make_step_costs(const StepOptions& options);
/// The same, for the surroundings of a start from which there is no other way out.
[[nodiscard]] StepCosts make_relief_costs(const StepOptions& options);

}  // namespace g3d::nav
