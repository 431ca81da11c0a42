// SPDX-License-Identifier: Apache-2.0
#include "nav/inflation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr int kMaxReach_cells = 120;
constexpr int kTile_shift = 4;
constexpr int kTile_cells = 1 << kTile_shift;
constexpr int kMaxWindow_cells = kTile_cells + 2 * kMaxReach_cells;

// costmap_2d's cellDistance(): the radius in cells, rounded up.
int reach_in_cells(const InflationConfig& config, double resolution_m) {
  const double cells = std::ceil(config.inflation_radius_m / resolution_m - 1e-6);
  return static_cast<int>(std::clamp(cells, 0.0, static_cast<double>(kMaxReach_cells)));
}

int tiles_for(int cells) { return (cells + kTile_cells - 1) >> kTile_shift; }

}  // namespace

std::uint8_t inflation_cost(double distance_m, const InflationConfig& config) {
  if (distance_m <= 0.0) return kLethalCost;
  if (distance_m <= config.inscribed_radius_m + 1e-9) return kInscribedCost;
  const double factor = std::exp(-config.decay_perm * (distance_m - config.inscribed_radius_m));
  return static_cast<std::uint8_t>((kInscribedCost - 1) * factor);
}

/// Squared distances in cells fit 16 bits: 120^2 + 121^2 < 2^15.
struct Inflation::Tile {
  std::array<std::array<std::int16_t, kMaxWindow_cells>, kTile_cells> column_squared;
  std::array<std::array<std::int16_t, kTile_cells>, kTile_cells> squared;
};

Inflation::Inflation(const CellGrid<CellState>& states, const InflationConfig& config)
    : config_(config),
      reach_cells_(reach_in_cells(config, states.resolution_m)),
      tile_columns_(tiles_for(states.columns)),
      tile_rows_(tiles_for(states.rows)),
      cost_(states.resolution_m, states.origin_x_m, states.origin_y_m, states.columns, states.rows, kUnknownCost),
      squared_cells_(states.cells.size(), static_cast<std::int16_t>(reach_cells_ * reach_cells_ + 1)),
      tile_noted_(static_cast<std::size_t>(tile_columns_) * static_cast<std::size_t>(tile_rows_)) {
  const int farthest = reach_cells_ * reach_cells_;
  for (int squared = 0; squared <= farthest; ++squared) {
    cost_of_squared_.push_back(inflation_cost(std::sqrt(squared) * states.resolution_m, config));
  }
  cost_of_squared_.push_back(kFreeCost);
  tiles_.reserve(tile_noted_.size());
  changed_.reserve(2 * states.cells.size());
}

double Inflation::clearance_m(Cell c) const {
  const double distance_m = std::sqrt(squared_cells_[cost_.index(c)]) * cost_.resolution_m;
  return std::min(distance_m, config_.inflation_radius_m);
}

void Inflation::update(const CellGrid<CellState>& states, std::span<const std::uint32_t> changed) {
  changed_.clear();
  for (const std::uint32_t index : changed) {
    const bool is_lethal = states.cells[index] == CellState::occupied;
    const bool was_lethal = squared_cells_[index] == 0;
    if (is_lethal == was_lethal) {
      set_cost(index, states.cells[index]);
    } else {
      note_tiles_around(states.cell(index));
    }
  }
  compute_noted(states);
}

void Inflation::rebuild(const CellGrid<CellState>& states) {
  changed_.clear();
  for (std::uint32_t tile = 0; tile < tile_noted_.size(); ++tile) {
    if (tile_noted_[tile] == 0) tiles_.push_back(tile);
    tile_noted_[tile] = 1;
  }
  compute_noted(states);
}

void Inflation::note_tiles_around(Cell c) {
  const int first_column = std::max(c.x - reach_cells_, 0) >> kTile_shift;
  const int last_column = std::min(c.x + reach_cells_, cost_.columns - 1) >> kTile_shift;
  const int first_row = std::max(c.y - reach_cells_, 0) >> kTile_shift;
  const int last_row = std::min(c.y + reach_cells_, cost_.rows - 1) >> kTile_shift;
  for (int row = first_row; row <= last_row; ++row) {
    for (int column = first_column; column <= last_column; ++column) {
      const auto tile = static_cast<std::uint32_t>(row * tile_columns_ + column);
      if (tile_noted_[tile] == 0) tiles_.push_back(tile);
      tile_noted_[tile] = 1;
    }
  }
}

void Inflation::compute_noted(const CellGrid<CellState>& states) {
  Tile tile;
  for (const std::uint32_t index : tiles_) {
    tile_noted_[index] = 0;
    const Cell low{static_cast<int>(index) % tile_columns_ * kTile_cells,
                   static_cast<int>(index) / tile_columns_ * kTile_cells};
    measure_columns(states, low, tile);
    combine_rows(tile);
    write_tile(states, low, tile);
  }
  tiles_.clear();
}

// Felzenszwalb and Huttenlocher 2012, first pass: each cell's squared distance to the next obstacle above or below.
void Inflation::measure_columns(const CellGrid<CellState>& states, Cell low, Tile& tile) const {
  const int none = reach_cells_ + 1;
  const int first_x = std::max(low.x - reach_cells_, 0);
  const int last_x = std::min(low.x + kTile_cells - 1 + reach_cells_, states.columns - 1);
  const int first_y = std::max(low.y - reach_cells_, 0);
  const int last_y = std::min(low.y + kTile_cells - 1 + reach_cells_, states.rows - 1);
  const std::size_t width = static_cast<std::size_t>(last_x - first_x) + 1;
  const std::size_t offset = static_cast<std::size_t>(first_x - (low.x - reach_cells_));
  for (auto& row : tile.column_squared) row.fill(static_cast<std::int16_t>(none * none));

  std::array<std::int16_t, kMaxWindow_cells> distance;
  const auto step_over = [&](int y) {
    const CellState* state = states.cells.data() + states.index({first_x, y});
    for (std::size_t i = 0; i < width; ++i) {
      const int farther = std::min(distance[i] + 1, none);
      distance[i] = static_cast<std::int16_t>(state[i] == CellState::occupied ? 0 : farther);
    }
    if (y < low.y || y >= low.y + kTile_cells) return;
    std::int16_t* out = tile.column_squared[static_cast<std::size_t>(y - low.y)].data() + offset;
    for (std::size_t i = 0; i < width; ++i) {
      out[i] = std::min(out[i], static_cast<std::int16_t>(distance[i] * distance[i]));
    }
  };
  distance.fill(static_cast<std::int16_t>(none));
  for (int y = first_y; y < std::min(low.y + kTile_cells, states.rows); ++y) step_over(y);
  distance.fill(static_cast<std::int16_t>(none));
  for (int y = last_y; y >= low.y; --y) step_over(y);
}

// Second pass: the nearest over all columns in reach.
void Inflation::combine_rows(Tile& tile) const {
  const auto none = static_cast<std::int16_t>(reach_cells_ * reach_cells_ + 1);
  for (std::size_t y = 0; y < kTile_cells; ++y) {
    auto& best = tile.squared[y];
    best.fill(none);
    for (int dx = -reach_cells_; dx <= reach_cells_; ++dx) {
      const std::int16_t* column = tile.column_squared[y].data() + (dx + reach_cells_);
      const auto across = static_cast<std::int16_t>(dx * dx);
      for (std::size_t x = 0; x < kTile_cells; ++x) {
        const auto squared = static_cast<std::int16_t>(column[x] + across);
        best[x] = squared < best[x] ? squared : best[x];
      }
    }
  }
}

void Inflation::write_tile(const CellGrid<CellState>& states, Cell low, const Tile& tile) {
  for (int y = low.y; y < std::min(low.y + kTile_cells, states.rows); ++y) {
    for (int x = low.x; x < std::min(low.x + kTile_cells, states.columns); ++x) {
      const std::size_t index = states.index({x, y});
      squared_cells_[index] = tile.squared[static_cast<std::size_t>(y - low.y)][static_cast<std::size_t>(x - low.x)];
      set_cost(index, states.cells[index]);
    }
  }
}

void Inflation::set_cost(std::size_t index, CellState state) {
  const std::uint8_t inflated = cost_of_squared_[static_cast<std::size_t>(squared_cells_[index])];
  const std::uint8_t cost = state == CellState::unknown && inflated < kInscribedCost ? kUnknownCost : inflated;
  if (cost == cost_.cells[index]) return;
  cost_.cells[index] = cost;
  changed_.push_back(static_cast<std::uint32_t>(index));
}

}  // namespace g3d::nav
