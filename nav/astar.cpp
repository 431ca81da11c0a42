// SPDX-License-Identifier: Apache-2.0
#include "nav/astar.hpp"

#include <algorithm>
#include <cassert>

namespace g3d::nav {

const char* to_string(PathStatus status) {
  switch (status) {
    case PathStatus::found:
      return "found";
    case PathStatus::unreachable:
      return "unreachable";
    case PathStatus::goal_blocked:
      return "goal blocked";
    case PathStatus::start_outside:
      return "start outside";
    case PathStatus::budget_spent:
      return "budget spent";
  }
  return "?";
}

// A cell waits in the queue at most once for each neighbour that it can be reached from.
AStar::AStar(std::size_t max_cells) : nodes_(max_cells), open_(8 * max_cells) { path_.reserve(max_cells); }

PathResult AStar::plan(const CellGrid<std::uint8_t>& cost, Cell start, std::span<const Cell> goals,
                       const AStarOptions& options) {
  assert(cost.cells.size() <= nodes_.size());
  if (!cost.contains(start)) return {PathStatus::start_outside, {}, 0, 0};
  if (++generation_ >> (32 - kGenerationShift) != 0) {
    nodes_.reset();
    generation_ = 1;
  }
  start_ = start;
  rule_ = StepRule(cost, start, options.steps);
  if (!mark_goals(cost, start, goals)) {
    open_.clear(0);
    return {PathStatus::goal_blocked, {}, 0, 0};
  }
  const auto index = static_cast<std::uint32_t>(cost.index(start));
  node(index).g = 0;
  const std::uint32_t f = heuristic(start.x, start.y);
  open_.clear(f);
  open_.push(f, index);
  return search(cost, options.max_expansions);
}

PathResult AStar::resume(const CellGrid<std::uint8_t>& cost, std::uint32_t max_expansions) {
  return search(cost, max_expansions);
}

bool AStar::mark_goals(const CellGrid<std::uint8_t>& cost, Cell start, std::span<const Cell> goals) {
  goal_low_ = {std::numeric_limits<int>::max(), std::numeric_limits<int>::max()};
  goal_high_ = {-1, -1};
  for (const Cell& goal : goals) {
    if (!cost.contains(goal) || (!rule_.can_stand(cost.at(goal)) && !(goal == start))) continue;
    goal_low_ = {std::min(goal_low_.x, goal.x), std::min(goal_low_.y, goal.y)};
    goal_high_ = {std::max(goal_high_.x, goal.x), std::max(goal_high_.y, goal.y)};
    node(static_cast<std::uint32_t>(cost.index(goal))).mark |= kGoal;
  }
  return goal_high_.x >= 0;
}

AStar::Node& AStar::node(std::uint32_t index) {
  Node& n = nodes_[index];
  if (n.mark >> kGenerationShift != generation_) n = {kFar, generation_ << kGenerationShift};
  return n;
}

// Octile distance over free floor to the box around the goals: no step shortens it by more than the step costs.
std::uint32_t AStar::heuristic(int x, int y) const {
  const int dx = std::max({goal_low_.x - x, x - goal_high_.x, 0});
  const int dy = std::max({goal_low_.y - y, y - goal_high_.y, 0});
  const auto diagonal = static_cast<std::uint32_t>(std::min(dx, dy));
  const auto straight = static_cast<std::uint32_t>(std::max(dx, dy)) - diagonal;
  return kDiagonalCost * diagonal + kStraightCost * straight;
}

PathResult AStar::search(const CellGrid<std::uint8_t>& cost, std::uint32_t max_expansions) {
  const auto columns = static_cast<std::uint32_t>(cost.columns);
  std::uint32_t expansions = 0;
  while (!open_.empty()) {
    if (expansions >= max_expansions) return {PathStatus::budget_spent, {}, 0, expansions};
    const std::uint32_t index = open_.pop();
    Node& current = nodes_[index];
    if ((current.mark & kClosed) != 0) continue;  // an older, costlier entry
    current.mark |= kClosed;
    ++expansions;
    const int x = static_cast<int>(index % columns);
    const int y = static_cast<int>(index / columns);
    if ((current.mark & kGoal) != 0) return {PathStatus::found, trace_back(cost, {x, y}), current.g, expansions};
    rule_.for_each_step(cost, index, x, y,
                        [&](std::uint32_t next, int next_x, int next_y, std::uint32_t price, std::uint32_t direction) {
                          Node& n = node(next);
                          const std::uint32_t g = current.g + price;
                          if (g >= n.g) return;
                          n.g = g;
                          n.mark = (n.mark & ~kDirectionMask) | direction;
                          open_.push(g + heuristic(next_x, next_y), next);
                        });
  }
  return {PathStatus::unreachable, {}, 0, expansions};
}

std::span<const Cell> AStar::trace_back(const CellGrid<std::uint8_t>& cost, Cell goal) {
  path_.clear();
  for (Cell c = goal;;) {
    path_.push_back(c);
    if (c == start_) break;
    const std::size_t direction = nodes_[cost.index(c)].mark & kDirectionMask;
    c = {c.x - kStepX[direction], c.y - kStepY[direction]};
  }
  std::reverse(path_.begin(), path_.end());
  return path_;
}

}  // namespace g3d::nav
