// SPDX-License-Identifier: Apache-2.0
// Travel cost from one cell to all others (Dijkstra), for whoever compares many goals. Same steps and costs as AStar,
// so cost_to(goal) is what a plan to this goal would cost. Thread: one. Sized at construction; compute() allocates
// nothing.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "mapper/grid_spread.hpp"
#include "mapper/pool.hpp"
#include "nav/bucket_queue.hpp"
#include "nav/cell_grid.hpp"
#include "nav/search_labels.hpp"
#include "nav/step_costs.hpp"

namespace g3d::nav {

struct DistanceOptions {
  StepOptions steps;
  std::uint32_t max_cost = SearchLabels::kRange - 1;  ///< farther cells count as not reached
};

/// The same question for a card; its answers are cost_to(), by cell index.
[[nodiscard]] mapper::GridSpread spread_of(const CellGrid<std::uint8_t>& cost, Cell start,
                                           const DistanceOptions& options = {});

class DistanceField {
 public:
  static constexpr std::uint32_t kUnreached = std::numeric_limits<std::uint32_t>::max();

  /// For grids of at most this many cells.
  explicit DistanceField(std::size_t max_cells);

  void compute(const CellGrid<std::uint8_t>& cost, Cell start, const DistanceOptions& options = {});

  /// In units of kStraightCost per free cell; kUnreached where there is no way, or outside.
  [[nodiscard]] std::uint32_t cost_to(Cell c) const {
    return c.x >= 0 && c.y >= 0 && c.x < columns_ && c.y < rows_
               ? cost_to(static_cast<std::uint32_t>(c.y) * static_cast<std::uint32_t>(columns_) +
                         static_cast<std::uint32_t>(c.x))
               : kUnreached;
  }
  /// By cell index, which must lie inside.
  [[nodiscard]] std::uint32_t cost_to(std::uint32_t index) const {
    return labels_.is_reached(index) ? labels_.g(index) : kUnreached;
  }
  /// Indices of all reached cells, nearest first.
  [[nodiscard]] std::span<const std::uint32_t> reached() const { return {reached_.data(), reached_count_}; }
  /// The way to a reached cell, start and goal included, into `path` (cleared; no allocation if it has room).
  bool path_to(Cell goal, std::vector<Cell>& path) const;

 private:
  SearchLabels labels_;
  mapper::ReservedArray<std::uint32_t> reached_;
  std::size_t reached_count_ = 0;
  BucketQueue open_;
  StepRule rule_;
  Cell start_;
  int columns_ = 0;
  int rows_ = 0;
};

}  // namespace g3d::nav
