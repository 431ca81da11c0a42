// SPDX-License-Identifier: Apache-2.0
// Where the body just fits. Costs keep the centre of the body half a cell and more from everything, because it may be
// anywhere in its cell; in a door that is hardly wider than the body that leaves no cell to stand on. But a path may
// lead through the edge between two cells, and where an obstacle's cells are taken for whole squares, a measurement's
// noise is in them already. So cells inside of that margin are looked at exactly: can the body stand anywhere in the
// cell's square without touching an occupied square? Where it has been before, it can be again: a wall's noise grows
// with every look, and must not lock the robot in. One thread. After construction nothing allocates.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"
#include "nav/inflation.hpp"

namespace g3d::nav {

class TightPlaces {
 public:
  static constexpr std::uint8_t kTightCost = kInscribedCost - 1;

  /// `spare_m`: what is left between body and squares at least.
  TightPlaces(const CellGrid<CellState>& states, const Inflation& inflation, double body_radius_m, double spare_m);

  /// After each inflation.update(states, changed), with the same cells.
  void update(const CellGrid<CellState>& states, const Inflation& inflation, std::span<const std::uint32_t> changed);
  /// The body's centre is here. Where it has been, half a cell less than its radius is enough from now on.
  void tread(const CellGrid<CellState>& states, const Inflation& inflation, double x_m, double y_m);
  /// The map has moved, and what was the body's way is elsewhere now: see tread().
  void forget_way(const CellGrid<CellState>& states, const Inflation& inflation);
  /// From now on its own way is open wherever no obstacle stands right in it: a last resort for a robot that is cut off
  /// from where it came from. False if that opens nothing.
  bool trust_own_way(const CellGrid<CellState>& states, const Inflation& inflation);

  /// The inflation's costs, with kTightCost where the body just fits.
  [[nodiscard]] const CellGrid<std::uint8_t>& cost() const { return cost_; }
  /// Cells whose cost the last update() or tread() changed, each once.
  [[nodiscard]] std::span<const std::uint32_t> changed_cells() const { return changed_; }

 private:
  void note(std::uint32_t cell);
  void mark(const CellGrid<CellState>& states, Cell c);
  void judge_noted(const CellGrid<CellState>& states, const Inflation& inflation);
  [[nodiscard]] bool fits(const CellGrid<CellState>& states, Cell c) const;

  double body_radius_m_;
  double spare_m_;
  int reach_cells_;  ///< squares farther than this do not matter
  CellGrid<std::uint8_t> cost_;
  std::vector<std::uint8_t> was_here_;  ///< per cell: the centre of the body
  std::vector<std::uint32_t> own_way_;  ///< those cells, each of which shares a side with the one before
  Cell here_{-2, -2};                   ///< the newest of them
  bool trusts_own_way_ = false;
  std::vector<std::uint32_t> noted_;
  std::vector<std::uint8_t> is_noted_;
  std::vector<std::uint32_t> changed_;
};

}  // namespace g3d::nav
