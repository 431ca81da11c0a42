// SPDX-License-Identifier: Apache-2.0
#include "nav/viewpoints.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nav/tight_places.hpp"

namespace g3d::nav {
namespace {

constexpr double kTile_m = 1.0;
constexpr int kRoadsPerPlace = 2;
constexpr int kLook_units = 250;
// Looking closer: from every third frontier cell, fewer if there are very many, in so many directions.
constexpr std::size_t kLeastStride = 3;
constexpr std::size_t kMostFrontierCells = 4096;
constexpr int kViewDirections = 120;
constexpr int kStepsPerUnit = 40;
constexpr int kNoPlace = TightPlaces::kTightCost;  ///< where the body just fits it drives through, and does not turn

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
  pass_ = 0;
  newest_round_.assign(tiles, 0);
  near_frontier_.assign(tiles, 0);
  cast_in_.assign(places, 0);
  closer_in_.assign(places, 0);
  seen_by_them_.assign(ground.cells.size(), 0);
  frontier_cells_.clear();
  frontier_cells_.reserve(kMostFrontierCells);
  look_closer(false);
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
    const std::uint32_t tile = static_cast<std::uint32_t>(tile_at(x, y));
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

std::uint32_t Viewpoints::newest_change(int tile_x, int tile_y) const {
  std::uint32_t newest = 0;
  for (int y = std::max(tile_y - reach_tiles_, 0); y <= std::min(tile_y + reach_tiles_, tile_rows_ - 1); ++y) {
    for (int x = std::max(tile_x - reach_tiles_, 0); x <= std::min(tile_x + reach_tiles_, tile_columns_ - 1); ++x) {
      newest = std::max(newest, changed_in_[tile_at(x, y)]);
    }
  }
  return newest;
}

bool Viewpoints::refresh(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost, const RoadGrid& roads,
                         const TravelField& from_robot, const FrontierMap& frontiers, const ViewGain& camera,
                         int max_casts) {
  begin_refresh(frontiers, camera, ground.resolution_m, max_casts);
  WorkBudget budget = WorkBudget::unlimited();
  (void)go_on(ground, cost, roads, from_robot, camera, budget);
  return is_complete_;
}

void Viewpoints::begin_refresh(const FrontierMap& frontiers, const ViewGain& camera, double resolution_m,
                               int max_casts) {
  reach_tiles_ = static_cast<int>(std::ceil(camera.model().far_m / (tile_cells_ * resolution_m)));
  mark_sight_of_frontiers(frontiers, reach_tiles_);
  useful_.clear();
  is_complete_ = true;
  casts_left_ = max_casts;
  next_ = 0;
  ++pass_;
  if (!is_closer_ || marked_directions_ > 0) return;
  const auto cells = frontiers.cells();
  const std::size_t stride = std::max(kLeastStride, cells.size() / kMostFrontierCells + 1);
  frontier_cells_.clear();
  for (std::size_t i = 0; i < cells.size(); i += stride) frontier_cells_.push_back(cells[i]);
  std::fill(seen_by_them_.begin(), seen_by_them_.end(), std::uint8_t{0});
}

bool Viewpoints::go_on(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost, const RoadGrid& roads,
                       const TravelField& from_robot, const ViewGain& camera, WorkBudget& budget) {
  while (is_closer_ && marked_directions_ < kViewDirections) {
    if (budget.is_spent()) return false;
    mark_seen_by_frontiers(ground, camera.model(), budget);
  }
  for (; next_ < from_robot.reached.size(); ++next_) {
    if (budget.is_spent()) return false;
    budget.spend(1);
    const std::uint32_t road = from_robot.reached[next_];
    const int px = static_cast<int>(road) % roads.columns() / kRoadsPerPlace;
    const int py = static_cast<int>(road) / roads.columns() / kRoadsPerPlace;
    const std::size_t place =
        static_cast<std::size_t>(py) * static_cast<std::size_t>(place_columns_) + static_cast<std::size_t>(px);
    if (visited_in_[place] == pass_) continue;
    visited_in_[place] = pass_;
    const int tx = std::min(px * kRoadsPerPlace * roads.stride() / tile_cells_, tile_columns_ - 1);
    const int ty = std::min(py * kRoadsPerPlace * roads.stride() / tile_cells_, tile_rows_ - 1);
    std::uint32_t& slot = slot_of_[place];
    if (near_frontier_[tile_at(tx, ty)] == 0) {
      if (slot != kNoSlot) free_slots_.push_back(slot);
      slot = kNoSlot;
      cast_in_[place] = 0;
      continue;
    }
    if (is_outdated(place, tx, ty)) {
      if (casts_left_ <= 0) {
        is_complete_ = false;
      } else {
        --casts_left_;
        budget.spend(kLook_units);
        cast(ground, cost, roads, from_robot, camera, place);
      }
    }
    if (is_closer_ && slot == kNoSlot && closer_in_[place] < newest_near_[tile_at(tx, ty)]) {
      if (casts_left_ <= 0) {
        is_complete_ = false;
      } else {
        --casts_left_;
        budget.spend(kLook_units * cast_closer(ground, cost, roads, from_robot, camera, place));
      }
    }
    if (slot != kNoSlot) useful_.push_back(slot);
  }
  return true;
}

bool Viewpoints::is_outdated(std::size_t place, int tile_x, int tile_y) {
  const std::size_t tile = tile_at(tile_x, tile_y);
  if (newest_round_[tile] != round_) {
    newest_round_[tile] = round_;
    newest_near_[tile] = newest_change(tile_x, tile_y);
  }
  return newest_near_[tile] > cast_in_[place] || cast_in_[place] == 0;
}

void Viewpoints::cast(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost, const RoadGrid& roads,
                      const TravelField& from_robot, const ViewGain& camera, std::size_t place) {
  const int px = static_cast<int>(place) % place_columns_;
  const int py = static_cast<int>(place) / place_columns_;
  Cell best;
  std::uint32_t best_road = 0;
  int best_cost = kNoPlace;
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
  Place found{best, best_road, 0.0F, {}};
  if (best_cost < kNoPlace) camera.look(ground, best, found.gain);
  for (const RayGain& ray : found.gain) found.total_cells += ray.cells;
  keep(place, found);
}

void Viewpoints::keep(std::size_t place, const Place& found) {
  std::uint32_t& slot = slot_of_[place];
  const bool is_useful = found.total_cells >= 0.5F;
  if (is_useful && slot == kNoSlot && !free_slots_.empty()) {
    slot = free_slots_.back();
    free_slots_.pop_back();
  }
  if (slot == kNoSlot) return;
  if (is_useful) {
    slots_[slot] = found;
    return;
  }
  free_slots_.push_back(slot);
  slot = kNoSlot;
}

void Viewpoints::mark_seen_by_frontiers(const CellGrid<CellState>& ground, const ViewModel& camera,
                                        WorkBudget& budget) {
  const int near_cells = static_cast<int>(camera.near_m / ground.resolution_m);
  const int far_cells = static_cast<int>(camera.far_m / ground.resolution_m);
  const double angle_rad = 2.0 * std::numbers::pi * marked_directions_++ / kViewDirections;
  const double dx = std::cos(angle_rad);
  const double dy = std::sin(angle_rad);
  std::int64_t steps = 0;
  for (const std::uint32_t from : frontier_cells_) {
    const double x0 = static_cast<int>(from) % columns_ + 0.5;
    const double y0 = static_cast<int>(from) / columns_ + 0.5;
    for (int step = 1; step <= far_cells; ++step, ++steps) {
      const Cell c{static_cast<int>(std::floor(x0 + step * dx)), static_cast<int>(std::floor(y0 + step * dy))};
      if (!ground.contains(c) || ground.at(c) != CellState::free) break;
      if (step >= near_cells) seen_by_them_[ground.index(c)] = 1;
    }
  }
  budget.spend(steps / kStepsPerUnit);
}

int Viewpoints::cast_closer(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost,
                            const RoadGrid& roads, const TravelField& from_robot, const ViewGain& camera,
                            std::size_t place) {
  const int side = kRoadsPerPlace * roads.stride();
  const int x0 = static_cast<int>(place) % place_columns_ * side;
  const int y0 = static_cast<int>(place) / place_columns_ * side;
  closer_in_[place] = round_;
  int looks = 0;
  Place best;
  for (int y = y0; y < std::min(y0 + side, cost.rows); ++y) {
    for (int x = x0; x < std::min(x0 + side, cost.columns); ++x) {
      const Cell c{x, y};
      Place found{c, static_cast<std::uint32_t>(y / roads.stride() * roads.columns() + x / roads.stride()), 0.0F, {}};
      if (seen_by_them_[ground.index(c)] == 0) continue;
      const bool is_reached = from_robot.distance[found.road] != TravelField::kNever;
      if (!is_reached || !roads.may_stand(c) || cost.at(c) >= kNoPlace) continue;
      ++looks;
      camera.look(ground, c, found.gain);
      for (const RayGain& ray : found.gain) found.total_cells += ray.cells;
      if (found.total_cells > best.total_cells) best = found;
    }
  }
  if (looks > 0) keep(place, best);
  return looks;
}

}  // namespace g3d::nav
