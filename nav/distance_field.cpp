// SPDX-License-Identifier: Apache-2.0
#include "nav/distance_field.hpp"

#include <algorithm>
#include <cassert>

namespace g3d::nav {

// A cell waits in the queue at most once for each neighbour that it can be reached from.
DistanceField::DistanceField(std::size_t max_cells) : nodes_(max_cells), reached_(max_cells), open_(8 * max_cells) {}

void DistanceField::compute(const CellGrid<std::uint8_t>& cost, Cell start, const DistanceOptions& options) {
  assert(cost.cells.size() <= nodes_.size());
  if (++generation_ >> (32 - kGenerationShift) != 0) {
    nodes_.reset();
    generation_ = 1;
  }
  columns_ = cost.columns;
  rows_ = cost.rows;
  reached_count_ = 0;
  start_ = start;
  if (!cost.contains(start)) return;
  rule_ = StepRule(cost, start, options.steps);

  const std::uint32_t fresh = generation_ << kGenerationShift;
  const auto start_index = static_cast<std::uint32_t>(cost.index(start));
  nodes_[start_index] = {0, fresh};
  open_.clear(0);
  open_.push(0, start_index);
  while (!open_.empty()) {
    const std::uint32_t index = open_.pop();
    Node& current = nodes_[index];
    if ((current.mark & kClosed) != 0) continue;  // an older, costlier entry
    current.mark |= kClosed;
    reached_[reached_count_++] = index;
    rule_.for_each_step(cost, index, static_cast<int>(index % static_cast<std::uint32_t>(columns_)),
                        static_cast<int>(index / static_cast<std::uint32_t>(columns_)),
                        [&](std::uint32_t next, int, int, std::uint32_t price, std::uint32_t direction) {
                          Node& n = nodes_[next];
                          const std::uint32_t g = current.g + price;
                          if (g > options.max_cost) return;
                          if (n.mark >> kGenerationShift == generation_ && g >= n.g) return;
                          n = {g, fresh | direction};
                          open_.push(g, next);
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
    const std::size_t direction = nodes_[index].mark & kDirectionMask;
    c = {c.x - kStepX[direction], c.y - kStepY[direction]};
  }
  std::reverse(path.begin(), path.end());
  return true;
}

}  // namespace g3d::nav
