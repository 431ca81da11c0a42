// SPDX-License-Identifier: Apache-2.0
#include "nav/inflation.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/floor_plans.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::nav;

namespace {

// costmap_2d's rules, cell by cell, obstacle by obstacle.
std::vector<std::uint8_t> plain_inflation(const CellGrid<CellState>& states, const InflationConfig& config) {
  std::vector<std::uint8_t> cost(states.cells.size());
  const int reach = static_cast<int>(std::ceil(config.inflation_radius_m / states.resolution_m - 1e-6));
  for (std::size_t i = 0; i < cost.size(); ++i) {
    const Cell c = states.cell(i);
    int best = reach * reach + 1;
    for (int y = std::max(c.y - reach, 0); y <= std::min(c.y + reach, states.rows - 1); ++y) {
      for (int x = std::max(c.x - reach, 0); x <= std::min(c.x + reach, states.columns - 1); ++x) {
        if (states.at({x, y}) != CellState::occupied) continue;
        best = std::min(best, (x - c.x) * (x - c.x) + (y - c.y) * (y - c.y));
      }
    }
    const double distance_m = std::sqrt(best) * states.resolution_m;
    std::uint8_t value = 0;
    if (best == 0) {
      value = 254;
    } else if (distance_m <= config.inscribed_radius_m + 1e-9) {
      value = 253;
    } else if (best <= reach * reach) {
      value =
          static_cast<std::uint8_t>(252.0 * std::exp(-config.decay_perm * (distance_m - config.inscribed_radius_m)));
    }
    cost[i] = states.cells[i] == CellState::unknown && value < 253 ? 255 : value;
  }
  return cost;
}

// Cells here and there, boxes, and now and then a great part of the floor.
std::vector<std::uint32_t> change_some(CellGrid<CellState>& states, tests::Random& random) {
  std::vector<std::uint32_t> changed;
  const std::uint32_t boxes = 1 + random.below(5);
  for (std::uint32_t i = 0; i < boxes; ++i) {
    const auto state = static_cast<CellState>(random.below(3));
    const std::uint32_t size = random.below(10) == 0 ? 30 : 1 + random.below(4);
    const int x0 = static_cast<int>(random.below(static_cast<std::uint32_t>(states.columns)));
    const int y0 = static_cast<int>(random.below(static_cast<std::uint32_t>(states.rows)));
    for (int y = y0; y < std::min(y0 + static_cast<int>(size), states.rows); ++y) {
      for (int x = x0; x < std::min(x0 + static_cast<int>(size), states.columns); ++x) {
        if (random.below(4) == 0) continue;
        if (states.at({x, y}) == state) continue;
        states.at({x, y}) = state;
        changed.push_back(static_cast<std::uint32_t>(states.index({x, y})));
      }
    }
  }
  return changed;
}

}  // namespace

TEST_CASE("Inflation follows costmap_2d's definition at every step of a changing floor") {
  const InflationConfig configs[] = {{}, {0.1, 0.3, 20.0}, {0.33, 0.33, 5.0}, {0.2, 1.0, 2.0}, {0.0, 0.0, 1.0}};
  std::uint64_t seed = 1;
  for (const InflationConfig& config : configs) {
    tests::Random random(++seed);
    CellGrid<CellState> states = tests::random_floor(seed, 75, 61);
    Inflation inflation(states, config);
    inflation.rebuild(states);
    REQUIRE(inflation.cost().cells == plain_inflation(states, config));
    for (int step = 0; step < 25; ++step) {
      const std::vector<std::uint8_t> before = inflation.cost().cells;
      std::vector<std::uint32_t> changed = change_some(states, random);
      changed.push_back(random.below(75 * 61));  // one that did not change
      inflation.update(states, changed);
      REQUIRE(inflation.cost().cells == plain_inflation(states, config));
      std::vector<std::uint8_t> told = before;
      for (const std::uint32_t i : inflation.changed_cells()) told[i] = inflation.cost().cells[i];
      REQUIRE(told == inflation.cost().cells);  // whoever follows the changes knows everything
    }
  }
}

TEST_CASE("A freshly made inflation is all unknown, as its floor is") {
  const CellGrid<CellState> states(0.05, 0, 0, 40, 40, CellState::unknown);
  const Inflation inflation(states, {});
  CHECK(std::count(inflation.cost().cells.begin(), inflation.cost().cells.end(), kUnknownCost) == 1600);
}

TEST_CASE("Costs have the values that costmap_2d gives") {
  // costmap_2d::InflationLayer::computeCost with inscribed radius 0.18 and weight 10, 5 cm cells.
  const InflationConfig config{0.18, 0.55, 10.0};
  CHECK(inflation_cost(0.0, config) == 254);
  CHECK(inflation_cost(0.15, config) == 253);
  CHECK(inflation_cost(0.18, config) == 253);
  CHECK(inflation_cost(0.20, config) == 206);  // 252 exp(-0.2) = 206.3
  CHECK(inflation_cost(0.50, config) == 10);   // 252 exp(-3.2) = 10.27
}

TEST_CASE("Clearance is measured between cell centres") {
  CellGrid<CellState> states(0.05, 0, 0, 60, 60, CellState::free);
  states.at({30, 30}) = CellState::occupied;
  Inflation inflation(states, {0.18, 0.5, 8.0});
  inflation.rebuild(states);
  CHECK(inflation.clearance_m({30, 30}) == 0.0);
  CHECK(inflation.clearance_m({33, 34}) == Approx(0.25));
  CHECK(inflation.clearance_m({30, 40}) == Approx(0.5));
  CHECK(inflation.clearance_m({0, 0}) == Approx(0.5));
}
