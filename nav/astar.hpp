// SPDX-License-Identifier: Apache-2.0
// A* on the inflated costs: eight neighbours, integer costs (step_costs.hpp), octile distance to the goals' bounding
// box as heuristic (consistent, so the path is optimal and no cell is expanded twice). Equal costs are settled by order
// of work alone, so that results repeat. Thread: one. Sized at construction; a plan allocates nothing.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "mapper/pool.hpp"
#include "nav/bucket_queue.hpp"
#include "nav/cell_grid.hpp"
#include "nav/search_labels.hpp"
#include "nav/step_costs.hpp"

namespace g3d::nav {

enum class PathStatus : std::uint8_t {
  found,
  unreachable,   ///< there is no way
  goal_blocked,  ///< no goal lies on the grid where the robot could stand
  start_outside,
  budget_spent,  ///< resume() goes on
};
[[nodiscard]] const char* to_string(PathStatus status);

struct AStarOptions {
  StepOptions steps;
  std::uint32_t max_expansions = std::numeric_limits<std::uint32_t>::max();  ///< per call of plan() or resume()
};

struct PathResult {
  PathStatus status = PathStatus::unreachable;
  std::span<const Cell> cells;   ///< start and goal included; valid until the planner's next call
  std::uint32_t cost = 0;        ///< in units of kStraightCost per free cell
  std::uint32_t expansions = 0;  ///< of this call
};

class AStar {
 public:
  /// For grids of at most this many cells.
  explicit AStar(std::size_t max_cells);

  /// The cheapest way from `start` to any of `goals`. The start cell itself may have any cost.
  PathResult plan(const CellGrid<std::uint8_t>& cost, Cell start, std::span<const Cell> goals,
                  const AStarOptions& options = {});
  /// Goes on after budget_spent. The grid must be what it was: a changed grid wants a new plan().
  PathResult resume(const CellGrid<std::uint8_t>& cost, std::uint32_t max_expansions);

 private:
  void mark_goals(const CellGrid<std::uint8_t>& cost, std::span<const Cell> goals);
  void clear_goal_side();
  [[nodiscard]] bool is_goal_side_closed(const CellGrid<std::uint8_t>& cost);
  [[nodiscard]] bool is_goal(std::uint32_t index, int x, int y) const;
  [[nodiscard]] std::uint32_t heuristic(int x, int y) const;
  PathResult search(const CellGrid<std::uint8_t>& cost, std::uint32_t max_expansions);
  [[nodiscard]] std::span<const Cell> trace_back(const CellGrid<std::uint8_t>& cost, Cell goal);

  SearchLabels labels_;
  BucketQueue open_;
  std::vector<Cell> path_;
  StepRule rule_;
  Cell start_;
  Cell goal_low_;  ///< bounding box of the goals
  Cell goal_high_;

  // The goals, and what can be reached from them: a flood that keeps pace with the search, until they meet or it is
  // large. If it runs dry, nobody needs to look at the rest of the building.
  mapper::ReservedArray<std::uint8_t> goal_side_;  ///< by cell: kGoal, kFlooded
  std::vector<std::uint32_t> flood_;               ///< indices of the cells that are marked in goal_side_
  std::size_t flood_next_ = 0;
  bool is_flooding_ = false;
};

}  // namespace g3d::nav
