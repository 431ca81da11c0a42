// SPDX-License-Identifier: Apache-2.0
#include "nav/tight_places.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace g3d::nav {
namespace {

constexpr int kMostReach_cells = 60;

}  // namespace

TightPlaces::TightPlaces(const CellGrid<CellState>& states, const Inflation& inflation, double body_radius_m,
                         double spare_m)
    : body_radius_m_(body_radius_m),
      spare_m_(spare_m),
      reach_cells_(
          std::min(static_cast<int>(std::ceil((body_radius_m + spare_m) / states.resolution_m)) + 1, kMostReach_cells)),
      cost_(inflation.cost()),
      was_here_(states.cells.size()),
      is_noted_(states.cells.size()) {
  noted_.reserve(states.cells.size());
  own_way_.reserve(states.cells.size());
  changed_.reserve(states.cells.size());
}

void TightPlaces::note(std::uint32_t cell) {
  if (is_noted_[cell] != 0) return;
  is_noted_[cell] = 1;
  noted_.push_back(cell);
}

void TightPlaces::update(const CellGrid<CellState>& states, const Inflation& inflation,
                         std::span<const std::uint32_t> changed) {
  for (const std::uint32_t cell : changed) note(cell);
  const CellGrid<std::uint8_t>& inflated = inflation.cost();
  for (const std::uint32_t cell : inflation.changed_cells()) {
    note(cell);
    if ((inflated.cells[cell] == kLethalCost) == (cost_.cells[cell] == kLethalCost)) continue;
    // An obstacle came or went. What is nearest to a cell may be something else, so its own cost may stay.
    const Cell c = states.cell(cell);
    for (int y = std::max(c.y - reach_cells_, 0); y <= std::min(c.y + reach_cells_, states.rows - 1); ++y) {
      for (int x = std::max(c.x - reach_cells_, 0); x <= std::min(c.x + reach_cells_, states.columns - 1); ++x) {
        const std::size_t near = states.index({x, y});
        if (inflated.cells[near] == kInscribedCost) note(static_cast<std::uint32_t>(near));
      }
    }
  }
  judge_noted(states, inflation);
}

void TightPlaces::mark(const CellGrid<CellState>& states, Cell c) {
  const std::uint32_t cell = static_cast<std::uint32_t>(states.index(c));
  if (was_here_[cell] != 0) return;
  was_here_[cell] = 1;
  own_way_.push_back(cell);
  note(cell);
}

void TightPlaces::tread(const CellGrid<CellState>& states, const Inflation& inflation, double x_m, double y_m) {
  const Cell c = states.cell_of(x_m, y_m);
  changed_.clear();
  if (!states.contains(c) || c == here_) return;
  // Across a corner: one of the two cells beside it belongs to the way, or no step would lead along it.
  if (std::abs(c.x - here_.x) == 1 && std::abs(c.y - here_.y) == 1) mark(states, {here_.x, c.y});
  here_ = c;
  mark(states, c);
  judge_noted(states, inflation);
}

void TightPlaces::forget_way(const CellGrid<CellState>& states, const Inflation& inflation) {
  for (const std::uint32_t cell : own_way_) {
    was_here_[cell] = 0;
    note(cell);
  }
  own_way_.clear();
  here_ = {-2, -2};
  judge_noted(states, inflation);
}

bool TightPlaces::trust_own_way(const CellGrid<CellState>& states, const Inflation& inflation) {
  changed_.clear();
  if (trusts_own_way_) return false;
  trusts_own_way_ = true;
  for (const std::uint32_t cell : own_way_) note(cell);
  judge_noted(states, inflation);
  return !changed_.empty();
}

void TightPlaces::judge_noted(const CellGrid<CellState>& states, const Inflation& inflation) {
  changed_.clear();
  for (const std::uint32_t cell : noted_) {
    is_noted_[cell] = 0;
    std::uint8_t value = inflation.cost().cells[cell];
    if (value == kInscribedCost && states.cells[cell] == CellState::free) {
      const Cell c = states.cell(cell);
      const double clearance_m = inflation.clearance_m(c);
      const bool has_been =
          was_here_[cell] != 0 && (trusts_own_way_ || clearance_m > body_radius_m_ - 0.5 * states.resolution_m);
      const bool may_fit = clearance_m > body_radius_m_ + spare_m_ - 0.5 * states.resolution_m;
      if (has_been || (may_fit && fits(states, c))) value = kTightCost;
    }
    if (value == cost_.cells[cell]) continue;
    cost_.cells[cell] = value;
    changed_.push_back(cell);
  }
  noted_.clear();
}

// The middle of the cell, of its sides, and its corners: gaps are whole cells wide, so the best place is one of them.
bool TightPlaces::fits(const CellGrid<CellState>& states, Cell c) const {
  std::array<bool, 9> is_open;
  is_open.fill(true);
  const double needed_cells = (body_radius_m_ + spare_m_) / states.resolution_m;
  const double needed = needed_cells * needed_cells - 1e-9;
  for (int y = std::max(c.y - reach_cells_, 0); y <= std::min(c.y + reach_cells_, states.rows - 1); ++y) {
    for (int x = std::max(c.x - reach_cells_, 0); x <= std::min(c.x + reach_cells_, states.columns - 1); ++x) {
      if (states.at({x, y}) != CellState::occupied) continue;
      for (int k = 0; k < 9; ++k) {
        const int column = k % 3 - 1;
        const int row = k / 3 - 1;
        const double dx = std::max(std::fabs(x - c.x - 0.5 * column) - 0.5, 0.0);
        const double dy = std::max(std::fabs(y - c.y - 0.5 * row) - 0.5, 0.0);
        if (dx * dx + dy * dy < needed) is_open[static_cast<std::size_t>(k)] = false;
      }
    }
  }
  return std::find(is_open.begin(), is_open.end(), true) != is_open.end();
}

}  // namespace g3d::nav
