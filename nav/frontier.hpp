// SPDX-License-Identifier: Apache-2.0
// Frontier cells: free cells with an unknown one beside them (4 neighbours). Kept from lists of changed cells; the
// result depends on the grid alone, not on how it came about. One thread; sized by reset().
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "nav/cell_grid.hpp"

namespace g3d::nav {

/// A connected piece (8 neighbours) of frontier cells: a range of FrontierMap::clustered_cells().
struct FrontierCluster {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

class FrontierMap {
 public:
  /// Reads the whole grid.
  void reset(const CellGrid<CellState>& ground);
  /// `changed` holds at least all cells whose state differs from the last call's, in any order, repeats allowed;
  /// the geometry is that of reset().
  void update(const CellGrid<CellState>& ground, std::span<const std::uint32_t> changed);

  [[nodiscard]] bool is_frontier(std::size_t cell) const { return place_[cell] != kNone; }
  /// In no particular order.
  [[nodiscard]] std::span<const std::uint32_t> cells() const { return cells_; }

  /// Groups the cells: clusters ordered by their lowest cell. Work is proportional to the number of frontier cells.
  void make_clusters();
  [[nodiscard]] std::span<const FrontierCluster> clusters() const { return clusters_; }
  [[nodiscard]] std::span<const std::uint32_t> clustered_cells() const { return clustered_; }
  [[nodiscard]] std::span<const std::uint32_t> cells_of(const FrontierCluster& cluster) const {
    return std::span<const std::uint32_t>(clustered_).subspan(cluster.first, cluster.count);
  }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  void check(const CellGrid<CellState>& ground, Cell c);

  int columns_ = 0;
  int rows_ = 0;
  std::vector<std::uint32_t> cells_;
  std::vector<std::uint32_t> place_;  ///< of a cell in cells_, or kNone
  std::vector<std::uint32_t> sorted_;
  std::vector<std::uint32_t> clustered_;
  std::vector<std::uint8_t> grouped_;  ///< by place in cells_
  std::vector<FrontierCluster> clusters_;
};

}  // namespace g3d::nav
