// SPDX-License-Identifier: Apache-2.0
#include "nav/viewpoints.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr double kTile_m = 1.0;
constexpr int kRoadsPerPlace = 2;

}  // namespace

void Viewpoints::reset(const CellGrid<CellState>& ground, const RoadGrid& roads) {
  columns_ = ground.columns;
  tile_cells_ = std::max(1, static_cast<int>(kTile_m / ground.resolution_m));
  tile_columns_ = (ground.columns + tile_cells_ - 1) / tile_cells_;
  tile_rows_ = (ground.rows + tile_cells_ - 1) / tile_cells_;
  const std::size_t tiles = static_cast<std::size_t>(tile_columns_) * static_cast<std::size_t>(tile_rows_);
  place_columns_ = (roads.columns() + kRoadsPerPlace - 1) / kRoadsPerPlace;
  const std::size_t places = static_cast<std::size_t>(place_columns_) *
                             static_cast<std::size_t>((roads.rows() + kRoadsPerPlace - 1) / kRoadsPerPlace);
  round_ = 1;
  changed_in_.assign(tiles, 1);
  newest_near_.assign(tiles, 0);
  newest_round_.assign(tiles, 0);
  near_frontier_.assign(tiles, 0);
  cast_in_.assign(places, 0);
  visited_in_.assign(places, 0);
  slot_of_.assign(places, kNoSlot);
  slots_.resize(kMaxPlaces);
  free_slots_.clear();
  free_slots_.reserve(kMaxPlaces);
  for (std::size_t i = kMaxPlaces; i-- > 0;) free_slots_.push_back(static_cast<std::uint32_t>(i));
  useful_.clear();
  useful_.reserve(kMaxPlaces);
}

void Viewpoints::note_changes(std::span<const std::uint32_t> changed) {
  ++round_;
  for (const std::uint32_t i : changed) {
    const int x = static_cast<int>(i) % columns_ / tile_cells_;
    const int y = static_cast<int>(i) / columns_ / tile_cells_;
    changed_in_[tile_at(x, y)] = round_;
  }
}

void Viewpoints::mark_sight_of_frontiers(const FrontierMap& frontiers, int reach_tiles) {
  std::fill(near_frontier_.begin(), near_frontier_.end(), std::uint8_t{0});
  std::uint32_t last_tile = kNoSlot;
  for (const std::uint32_t i : frontiers.cells()) {
    const int x = static_cast<int>(i) % columns_ / tile_cells_;
    const int y = static_cast<int>(i) / columns_ / tile_cells_;
    const auto tile = static_cast<std::uint32_t>(tile_at(x, y));
    if (tile == last_tile || (near_frontier_[tile] & 2U) != 0) continue;
    last_tile = tile;
    for (int ty = std::max(y - reach_tiles, 0); ty <= std::min(y + reach_tiles, tile_rows_ - 1); ++ty) {
      for (int tx = std::max(x - reach_tiles, 0); tx <= std::min(x + reach_tiles, tile_columns_ - 1); ++tx) {
        near_frontier_[tile_at(tx, ty)] |= 1U;
      }
    }
    near_frontier_[tile] |= 2U;
  }
}

std::uint32_t Viewpoints::newest_change(int tile_x, int tile_y, int reach_tiles) const {
  std::uint32_t newest = 0;
  for (int y = std::max(tile_y - reach_tiles, 0); y <= std::min(tile_y + reach_tiles, tile_rows_ - 1); ++y) {
    for (int x = std::max(tile_x - reach_tiles, 0); x <= std::min(tile_x + reach_tiles, tile_columns_ - 1); ++x) {
      newest = std::max(newest, changed_in_[tile_at(x, y)]);
    }
  }
  return newest;
}

bool Viewpoints::refresh(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost, const RoadGrid& roads,
                         const TravelField& from_robot, const FrontierMap& frontiers, const ViewGain& camera,
                         int budget) {
  const int reach = static_cast<int>(std::ceil(camera.model().far_m / (tile_cells_ * ground.resolution_m)));
  mark_sight_of_frontiers(frontiers, reach);
  useful_.clear();
  bool complete = true;
  ++round_;
  for (const std::uint32_t road : from_robot.reached) {
    const int px = static_cast<int>(road) % roads.columns() / kRoadsPerPlace;
    const int py = static_cast<int>(road) / roads.columns() / kRoadsPerPlace;
    const std::size_t place =
        static_cast<std::size_t>(py) * static_cast<std::size_t>(place_columns_) + static_cast<std::size_t>(px);
    if (visited_in_[place] == round_) continue;
    visited_in_[place] = round_;
    const int tx = std::min(px * kRoadsPerPlace * roads.stride() / tile_cells_, tile_columns_ - 1);
    const int ty = std::min(py * kRoadsPerPlace * roads.stride() / tile_cells_, tile_rows_ - 1);
    const std::size_t tile = tile_at(tx, ty);
    std::uint32_t& slot = slot_of_[place];
    if (near_frontier_[tile] == 0) {
      if (slot != kNoSlot) free_slots_.push_back(slot);
      slot = kNoSlot;
      cast_in_[place] = 0;
      continue;
    }
    if (newest_round_[tile] != round_) {
      newest_round_[tile] = round_;
      newest_near_[tile] = newest_change(tx, ty, reach);
    }
    if (newest_near_[tile] > cast_in_[place] || cast_in_[place] == 0) {
      if (budget <= 0) {
        complete = false;
      } else {
        --budget;
        Cell best;
        std::uint32_t best_road = road;
        int best_cost = 256;
        for (int k = 0; k < kRoadsPerPlace * kRoadsPerPlace; ++k) {
          const int rx = px * kRoadsPerPlace + k % kRoadsPerPlace;
          const int ry = py * kRoadsPerPlace + k / kRoadsPerPlace;
          if (rx >= roads.columns() || ry >= roads.rows()) continue;
          const std::uint32_t r = static_cast<std::uint32_t>(ry * roads.columns() + rx);
          Cell c;
          if (from_robot.distance[r] == TravelField::kNever || !roads.best_cell(cost, r, c)) continue;
          if (cost.at(c) >= best_cost) continue;
          best_cost = cost.at(c);
          best = c;
          best_road = r;
        }
        cast_in_[place] = round_;
        if (best_cost < 256 && slot == kNoSlot && !free_slots_.empty()) {
          slot = free_slots_.back();
          free_slots_.pop_back();
        }
        if (best_cost < 256 && slot != kNoSlot) {
          Place& p = slots_[slot];
          p.cell = best;
          p.road = best_road;
          camera.look(ground, best, p.gain);
          p.total_cells = 0.0F;
          for (const RayGain& ray : p.gain) p.total_cells += ray.cells;
        }
        if (slot != kNoSlot && (best_cost == 256 || slots_[slot].total_cells < 0.5F)) {
          free_slots_.push_back(slot);
          slot = kNoSlot;
        }
      }
    }
    if (slot != kNoSlot) useful_.push_back(slot);
  }
  return complete;
}

}  // namespace g3d::nav
