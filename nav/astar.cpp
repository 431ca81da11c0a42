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

namespace {

constexpr std::uint8_t kGoal = 1, kFlooded = 2;
constexpr std::size_t kMaxFlood_cells = 60000;  // 150 m2 at 5 cm; in all half a millisecond

}  // namespace

// A cell waits in the queue at most once for each neighbour that it can be reached from.
AStar::AStar(std::size_t max_cells) : labels_(max_cells), open_(8 * max_cells), goal_side_(max_cells) {
  path_.reserve(max_cells);
  flood_.reserve(max_cells);
}

PathResult AStar::plan(const CellGrid<std::uint8_t>& cost, Cell start, std::span<const Cell> goals,
                       const AStarOptions& options) {
  assert(cost.cells.size() <= labels_.size() && cost.columns < 65536 && cost.rows < 65536);
  open_.clear(0);
  clear_goal_side();
  if (!cost.contains(start)) return {PathStatus::start_outside, {}, 0, 0};
  start_ = start;
  rule_ = StepRule(cost, start, options.steps);
  mark_goals(cost, goals);
  if (flood_.empty()) return {PathStatus::goal_blocked, {}, 0, 0};
  is_flooding_ = !rule_.gives_relief();
  labels_.begin();
  labels_.improve(static_cast<std::uint32_t>(cost.index(start)), 0, 0);
  const std::uint32_t f = heuristic(start.x, start.y);
  open_.clear(f);
  open_.push(f, packed(start.x, start.y));
  return search(cost, options.max_expansions);
}

PathResult AStar::resume(const CellGrid<std::uint8_t>& cost, std::uint32_t max_expansions) {
  return search(cost, max_expansions);
}

void AStar::mark_goals(const CellGrid<std::uint8_t>& cost, std::span<const Cell> goals) {
  goal_low_ = {std::numeric_limits<int>::max(), std::numeric_limits<int>::max()};
  goal_high_ = {-1, -1};
  for (const Cell& goal : goals) {
    if (!cost.contains(goal) || (!rule_.can_stand(cost.at(goal)) && !(goal == start_))) continue;
    std::uint8_t& mark = goal_side_[cost.index(goal)];
    if (mark != 0) continue;
    mark = kGoal | kFlooded;
    flood_.push_back(static_cast<std::uint32_t>(cost.index(goal)));
    goal_low_ = {std::min(goal_low_.x, goal.x), std::min(goal_low_.y, goal.y)};
    goal_high_ = {std::max(goal_high_.x, goal.x), std::max(goal_high_.y, goal.y)};
  }
}

void AStar::clear_goal_side() {
  for (const std::uint32_t index : flood_) goal_side_[index] = 0;
  flood_.clear();
  flood_next_ = 0;
}

// One step of the flood; true if the goals turn out to lie behind closed doors. Diagonal steps need both cells beside
// them, so four neighbours reach what eight do.
bool AStar::is_goal_side_closed(const CellGrid<std::uint8_t>& cost) {
  if (flood_next_ == flood_.size()) return true;
  const std::uint32_t index = flood_[flood_next_++];
  const auto columns = static_cast<std::uint32_t>(cost.columns);
  const Cell c{static_cast<int>(index % columns), static_cast<int>(index / columns)};
  if (c == start_ || labels_.is_closed(index) || flood_.size() > kMaxFlood_cells) {
    is_flooding_ = false;  // they have met, or it is large
    return false;
  }
  for (std::size_t d = 0; d < 4; ++d) {
    const Cell next{c.x + kStepX[d], c.y + kStepY[d]};
    if (!cost.contains(next)) continue;
    const std::size_t next_index = cost.index(next);
    if (goal_side_[next_index] != 0 || (!rule_.can_stand(cost.cells[next_index]) && !(next == start_))) continue;
    goal_side_[next_index] = kFlooded;
    flood_.push_back(static_cast<std::uint32_t>(next_index));
  }
  return false;
}

bool AStar::is_goal(std::uint32_t index, int x, int y) const {
  return x >= goal_low_.x && x <= goal_high_.x && y >= goal_low_.y && y <= goal_high_.y &&
         (goal_side_[index] & kGoal) != 0;
}

// Octile distance over free floor to the box around the goals: no step shortens it by more than the step costs.
std::uint32_t AStar::heuristic(int x, int y) const {
  const int dx = std::max(std::max(goal_low_.x - x, x - goal_high_.x), 0);
  const int dy = std::max(std::max(goal_low_.y - y, y - goal_high_.y), 0);
  const auto diagonal = static_cast<std::uint32_t>(std::min(dx, dy));
  const auto straight = static_cast<std::uint32_t>(std::max(dx, dy)) - diagonal;
  return kDiagonalCost * diagonal + kStraightCost * straight;
}

PathResult AStar::search(const CellGrid<std::uint8_t>& cost, std::uint32_t max_expansions) {
  const auto columns = static_cast<std::uint32_t>(cost.columns);
  std::uint32_t expansions = 0;
  while (!open_.empty()) {
    if (expansions >= max_expansions) return {PathStatus::budget_spent, {}, 0, expansions};
    const std::uint32_t cell = open_.pop();
    const int x = packed_x(cell);
    const int y = packed_y(cell);
    const std::uint32_t index = static_cast<std::uint32_t>(y) * columns + static_cast<std::uint32_t>(x);
    if (!labels_.close(index)) continue;  // an older, costlier entry
    ++expansions;
    const std::uint32_t g = labels_.g(index);
    if (is_goal(index, x, y)) {
      open_.clear(0);
      return {PathStatus::found, trace_back(cost, {x, y}), g, expansions};
    }
    if (open_.key() >= SearchLabels::kRange - kMaxStepCost || (is_flooding_ && is_goal_side_closed(cost))) break;
    rule_.for_each_step(cost, index, x, y,
                        [&](std::uint32_t next, int next_x, int next_y, std::uint32_t price, std::uint32_t direction) {
                          if (!labels_.improve(next, g + price, direction)) return;
                          open_.push(g + price + heuristic(next_x, next_y), packed(next_x, next_y));
                        });
  }
  open_.clear(0);
  return {PathStatus::unreachable, {}, 0, expansions};
}

std::span<const Cell> AStar::trace_back(const CellGrid<std::uint8_t>& cost, Cell goal) {
  path_.clear();
  for (Cell c = goal;;) {
    path_.push_back(c);
    if (c == start_) break;
    const std::size_t direction = labels_.direction(static_cast<std::uint32_t>(cost.index(c)));
    c = {c.x - kStepX[direction], c.y - kStepY[direction]};
  }
  std::reverse(path_.begin(), path_.end());
  return path_;
}

}  // namespace g3d::nav
