// SPDX-License-Identifier: Apache-2.0
#include "tests/support/plain_planner.hpp"

#include <cstdlib>
#include <functional>
#include <queue>
#include <utility>

namespace g3d::tests {
namespace {

using nav::Cell;
using Costs = nav::CellGrid<std::uint8_t>;

// Entering `to` from its neighbour `from`; kNoWay if that cannot be done.
std::uint32_t step_price(const Costs& cost, Cell from, Cell to, Cell start, const nav::StepOptions& options) {
  const bool stands_tight = cost.at(start) == 253 || cost.at(start) == 254;
  const bool relief = stands_tight && std::abs(from.x - start.x) <= options.relief_cells &&
                      std::abs(from.y - start.y) <= options.relief_cells;
  const auto straight = [&](Cell c) -> std::uint32_t {
    if (!cost.contains(c)) return kNoWay;
    std::uint32_t value = cost.at(c);
    if (value == 254 || (value == 253 && !relief) || (value == 255 && !options.allow_unknown)) return kNoWay;
    if (value == 253) return 600;
    if (value == 255) value = options.unknown_as;
    return 50 + (8 * value + 5) / 10;
  };
  const std::uint32_t entering = straight(to);
  if (entering == kNoWay || from.x == to.x || from.y == to.y) return entering;
  if (straight({to.x, from.y}) == kNoWay || straight({from.x, to.y}) == kNoWay) return kNoWay;
  return (entering * 99 + 35) / 70;
}

}  // namespace

std::vector<std::uint32_t> plain_dijkstra(const Costs& cost, Cell start, const nav::StepOptions& options) {
  std::vector<std::uint32_t> best(cost.cells.size(), kNoWay);
  using Entry = std::pair<std::uint32_t, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  best[cost.index(start)] = 0;
  open.emplace(0, cost.index(start));
  while (!open.empty()) {
    const auto [g, index] = open.top();
    open.pop();
    if (g != best[index]) continue;
    const Cell from = cost.cell(index);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Cell to{from.x + dx, from.y + dy};
        if (to == from || !cost.contains(to)) continue;
        const std::uint32_t price = step_price(cost, from, to, start, options);
        if (price == kNoWay || g + price >= best[cost.index(to)]) continue;
        best[cost.index(to)] = g + price;
        open.emplace(g + price, cost.index(to));
      }
    }
  }
  return best;
}

std::uint32_t walked_cost(const Costs& cost, const std::vector<Cell>& path, const nav::StepOptions& options) {
  std::uint32_t sum = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Cell a = path[i - 1];
    const Cell b = path[i];
    if (a == b || std::abs(a.x - b.x) > 1 || std::abs(a.y - b.y) > 1) return kNoWay;
    const std::uint32_t price = step_price(cost, a, b, path.front(), options);
    if (price == kNoWay) return kNoWay;
    sum += price;
  }
  return sum;
}

}  // namespace g3d::tests
