// SPDX-License-Identifier: Apache-2.0
// A question about a grid of costs: what it takes to get from one cell to every other one, in whole numbers. Its CPU
// twin is nav::DistanceField. Plain data: it goes to a card as it is.
#pragma once

#include <cstdint>

namespace g3d::mapper {

/// By cost of the cell that is entered; 0: not possible. A diagonal step also needs both straight ones beside it.
struct StepPrices {
  std::uint16_t straight[256];
  std::uint16_t diagonal[256];
};

struct GridSpread {
  std::int32_t columns;
  std::int32_t rows;
  std::int32_t start_x;
  std::int32_t start_y;
  std::int32_t relief_cells;  ///< steps from cells so near to the start (in both axes) have the second prices; -1: none
  std::uint32_t max_cost;     ///< farther cells count as not reached; below 2^26
  StepPrices prices[2];
};

inline constexpr std::uint32_t kNotReached = 0xFFFFFFFFU;

}  // namespace g3d::mapper
