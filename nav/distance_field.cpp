// SPDX-License-Identifier: Apache-2.0
#include "nav/distance_field.hpp"

#include <algorithm>
#include <cassert>

namespace g3d::nav {

static_assert(DistanceField::kUnreached == mapper::kNotReached);

mapper::GridSpread spread_of(const CellGrid<std::uint8_t>& cost, Cell start, const DistanceOptions& options) {
  mapper::GridSpread spread{};
  spread.columns = cost.columns;
  spread.rows = cost.rows;
  spread.start_x = start.x;
  spread.start_y = start.y;
  spread.max_cost = std::min(options.max_cost, SearchLabels::kRange - 1);
  spread.relief_cells =
      cost.contains(start) && StepRule(cost, start, options.steps).gives_relief() ? options.steps.relief_cells : -1;
  const auto set = [](const StepCosts& from, mapper::StepPrices& to) {
    std::copy(from.straight.begin(), from.straight.end(), to.straight);
    std::copy(from.diagonal.begin(), from.diagonal.end(), to.diagonal);
  };
  set(make_step_costs(options.steps), spread.prices[0]);
  set(make_relief_costs(options.steps), spread.prices[1]);
  return spread;
}

// A cell waits in the queue at most once for each neighbour that it can be reached from.
DistanceField::DistanceField(std::size_t max_cells) : labels_(max_cells), reached_(max_cells), open_(8 * max_cells) {}

void DistanceField::compute(const CellGrid<std::uint8_t>& cost, Cell start, const DistanceOptions& options) {
  assert(cost.cells.size() <= labels_.size() && cost.columns < 65536 && cost.rows < 65536);
  labels_.begin();
  columns_ = cost.columns;
  rows_ = cost.rows;
  reached_count_ = 0;
  start_ = start;
  if (!cost.contains(start)) return;
  rule_ = StepRule(cost, start, options.steps);

  const std::uint32_t max_cost = std::min(options.max_cost, SearchLabels::kRange - 1);
  labels_.improve(static_cast<std::uint32_t>(cost.index(start)), 0, 0);
  open_.clear(0);
  open_.push(0, packed(start.x, start.y));
  while (!open_.empty()) {
    const std::uint32_t cell = open_.pop();
    const int x = packed_x(cell);
    const int y = packed_y(cell);
    const auto index = static_cast<std::uint32_t>(y * columns_ + x);
    if (!labels_.close(index)) continue;  // an older, costlier entry
    reached_[reached_count_++] = index;
    const std::uint32_t g = open_.key();
    rule_.for_each_step(cost, index, x, y,
                        [&](std::uint32_t next, int next_x, int next_y, std::uint32_t price, std::uint32_t direction) {
                          if (g + price > max_cost || !labels_.improve(next, g + price, direction)) return;
                          open_.push(g + price, packed(next_x, next_y));
                        });
  }
}

bool DistanceField::path_to(Cell goal, std::vector<Cell>& path) const {
  path.clear();
  if (cost_to(goal) == kUnreached) return false;
  for (Cell c = goal;;) {
    path.push_back(c);
    if (c == start_) break;
    const std::size_t index =
        static_cast<std::size_t>(c.y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(c.x);
    const std::size_t direction = labels_.direction(static_cast<std::uint32_t>(index));
    c = {c.x - kStepX[direction], c.y - kStepY[direction]};
  }
  std::reverse(path.begin(), path.end());
  return true;
}

}  // namespace g3d::nav
