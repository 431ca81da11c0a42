// SPDX-License-Identifier: Apache-2.0
// Costs of the robot's centre as costmap_2d defines them (inflation layer): an obstacle 254; within the inscribed
// radius 253; up to the inflation radius floor(252 exp(-k (d - r_inscribed))); unknown 255 unless it lies within the
// inscribed radius of an obstacle. Distances are exact, from cell centre to cell centre (costmap_2d's own search is off
// by a cell at times). Kept up to date from the cells that changed, in tiles: a tile near a changed obstacle is
// computed anew from its surroundings, so the result is that of a computation from scratch. Thread: one. After
// construction nothing allocates.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "nav/cell_grid.hpp"

namespace g3d::nav {

struct InflationConfig {
  double inscribed_radius_m = 0.18;  ///< of the round footprint
  double inflation_radius_m = 0.55;  ///< at most 120 cells
  double decay_perm = 8.0;           ///< k
};

class Inflation {
 public:
  /// For grids of this size and resolution, all unknown at first.
  Inflation(const CellGrid<CellState>& states, const InflationConfig& config);

  /// `changed`: indices of all cells whose state changed since the last call (more do no harm).
  void update(const CellGrid<CellState>& states, std::span<const std::uint32_t> changed);
  void rebuild(const CellGrid<CellState>& states);

  [[nodiscard]] const CellGrid<std::uint8_t>& cost() const { return cost_; }
  /// Cells whose cost the last update() or rebuild() changed. May name a cell twice.
  [[nodiscard]] std::span<const std::uint32_t> changed_cells() const { return changed_; }
  /// From the cell's centre to that of the nearest obstacle; inflation_radius_m() where there is none so near.
  [[nodiscard]] double clearance_m(Cell c) const;
  [[nodiscard]] double inflation_radius_m() const { return config_.inflation_radius_m; }
  [[nodiscard]] const InflationConfig& config() const { return config_; }

 private:
  struct Tile;

  void note_tiles_around(Cell c);
  void compute_noted(const CellGrid<CellState>& states);
  void measure_columns(const CellGrid<CellState>& states, Cell low, Tile& tile) const;
  void combine_rows(Tile& tile) const;
  void write_tile(const CellGrid<CellState>& states, Cell low, const Tile& tile);
  void set_cost(std::size_t index, CellState state);

  InflationConfig config_;
  int reach_cells_;  ///< farther obstacles do not count
  int tile_columns_;
  int tile_rows_;
  CellGrid<std::uint8_t> cost_;
  std::vector<std::uint8_t> cost_of_squared_;  ///< by squared distance in cells; the last entry: none in reach
  std::vector<std::int16_t> squared_cells_;    ///< to the nearest obstacle, at most reach^2 + 1
  std::vector<std::uint32_t> tiles_;           ///< to compute anew
  std::vector<std::uint8_t> tile_noted_;
  std::vector<std::uint32_t> changed_;
};

/// The definition itself, for any distance.
[[nodiscard]] std::uint8_t inflation_cost(double distance_m, const InflationConfig& config);

}  // namespace g3d::nav
