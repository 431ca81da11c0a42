// SPDX-License-Identifier: Apache-2.0
#include "tests/support/plain_ground.hpp"

#include <cmath>

namespace g3d::tests {
namespace {

using nav::Cell;
using nav::CellGrid;
using nav::CellState;

struct Seen {
  int band_hits = 0;
  bool twice = false;  ///< one voxel hit more than once
  bool floor = false;
  bool air = false;
  bool low = false;
  bool drop = false;
};

}  // namespace

CellGrid<CellState> plain_ground(const mapper::VoxelMap& map, const CellGrid<CellState>& like,
                                 const nav::GroundMapConfig& config) {
  const double r_m = static_cast<double>(map.grid().resolution_m);
  const int voxels = static_cast<int>(std::lround(like.resolution_m / r_m));
  const int first_x = static_cast<int>(std::lround(like.origin_x_m / r_m)) + 32768;
  const int first_y = static_cast<int>(std::lround(like.origin_y_m / r_m)) + 32768;
  const nav::GroundLayers layers = nav::ground_layers(map.grid(), config.heights);
  std::vector<Seen> seen(like.cells.size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Cell c = like.cell(i);
    Seen& cell = seen[i];
    for (int v = 0; v < voxels * voxels; ++v) {
      for (std::int32_t z = layers.first(); z <= layers.last(); ++z) {
        const mapper::Rgbo value =
            map.at({first_x + c.x * voxels + v % voxels, first_y + c.y * voxels + v / voxels, z});
        const bool occupied = mapper::state_of(value) == mapper::State::occupied;
        const bool free = mapper::state_of(value) == mapper::State::free;
        cell.floor |= occupied && layers.floor.contains(z);
        cell.air |= free && layers.air.contains(z);
        cell.low |= free && layers.low.contains(z);
        cell.drop |= free && layers.drop.contains(z);
        if (!occupied || !layers.band.contains(z)) continue;
        ++cell.band_hits;
        cell.twice |= mapper::level_of(value) > config.speckle_level;
      }
    }
  }
  const auto any_near = [&](Cell c, double radius_cells, auto&& condition) {
    const int reach = static_cast<int>(radius_cells);
    for (int y = c.y - reach; y <= c.y + reach; ++y) {
      for (int x = c.x - reach; x <= c.x + reach; ++x) {
        if (Cell{x, y} == c || !like.contains({x, y}) || std::hypot(x - c.x, y - c.y) > radius_cells) continue;
        if (condition(seen[like.index({x, y})])) return true;
      }
    }
    return false;
  };
  CellGrid<CellState> ground = like;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Seen& cell = seen[i];
    const Cell c = like.cell(i);
    const bool drop = cell.drop && !cell.floor;
    const bool hit = cell.band_hits > 1 || cell.twice ||
                     (cell.band_hits == 1 && any_near(c, 1.5, [](const Seen& s) { return s.band_hits > 0; }));
    const auto is_drop = [](const Seen& s) { return s.drop && !s.floor; };
    CellState& state = ground.cells[i];
    state = CellState::unknown;
    if (hit) {
      state = CellState::occupied;
    } else if (cell.floor) {
      state = CellState::free;
    } else if (drop) {
      state = CellState::occupied;
    } else if (cell.air) {
      const double margin_cells = (config.margin_m + 1e-6) / like.resolution_m;
      const bool has_floor_near = any_near(c, margin_cells, [](const Seen& s) { return s.floor; });
      if (any_near(c, margin_cells, is_drop)) {
        state = CellState::occupied;
      } else if (has_floor_near || !cell.low) {
        state = CellState::free;
      }
    }
  }
  return ground;
}

}  // namespace g3d::tests
