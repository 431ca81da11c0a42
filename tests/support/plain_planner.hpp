// SPDX-License-Identifier: Apache-2.0
// What the planners must agree with, in its plainest form: Dijkstra with std::priority_queue, written from the rules
// (step_costs.hpp) and not from the planners.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "nav/cell_grid.hpp"
#include "nav/step_costs.hpp"

namespace g3d::tests {

inline constexpr std::uint32_t kNoWay = std::numeric_limits<std::uint32_t>::max();

/// Cost of the cheapest way from start to every cell, kNoWay where there is none.
[[nodiscard]] std::vector<std::uint32_t> plain_dijkstra(const nav::CellGrid<std::uint8_t>& cost, nav::Cell start,
                                                        const nav::StepOptions& options);

/// What walking along these cells costs; kNoWay if a step is not one.
[[nodiscard]] std::uint32_t walked_cost(const nav::CellGrid<std::uint8_t>& cost, const std::vector<nav::Cell>& path,
                                        const nav::StepOptions& options);

}  // namespace g3d::tests
