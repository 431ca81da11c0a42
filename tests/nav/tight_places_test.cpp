// SPDX-License-Identifier: Apache-2.0
#include "nav/tight_places.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "nav/surroundings.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::nav;

namespace {

constexpr double kBody_m = 0.18;
constexpr double kSpare_m = 0.01;

struct Floor {
  CellGrid<CellState> states{0.05, 0.0, 0.0, 60, 60, CellState::free};
  Inflation inflation{states, {planning_radius_m(kBody_m, 0.05), 0.55, 8.0}};
  TightPlaces tight{states, inflation, kBody_m, kSpare_m};

  /// A wall along x = 30, 31 with a gap from y = 20 on.
  explicit Floor(int gap_cells = 0) {
    std::vector<std::uint32_t> changed;
    for (std::uint32_t i = 0; i < states.cells.size(); ++i) changed.push_back(i);
    if (gap_cells > 0) {
      for (int y = 0; y < 60; ++y) {
        if (y >= 20 && y < 20 + gap_cells) continue;
        states.at({30, y}) = states.at({31, y}) = CellState::occupied;
      }
    }
    update(changed);
  }
  void update(std::span<const std::uint32_t> changed) {
    inflation.update(states, changed);
    tight.update(states, inflation, changed);
  }
  [[nodiscard]] bool leads_through(int y) const {
    for (int x = 26; x < 36; ++x) {
      if (tight.cost().at({x, y}) >= kInscribedCost) return false;
    }
    return true;
  }
  [[nodiscard]] int ways_through() const {
    int ways = 0;
    for (int y = 0; y < 60; ++y) ways += leads_through(y);
    return ways;
  }
};

}  // namespace

TEST_CASE("a gap of 40 cm lets a body of 36 cm through, along the edge between two cells; one of 35 cm does not") {
  CHECK(Floor(7).ways_through() == 0);
  const Floor eight(8);
  CHECK(eight.ways_through() == 2);
  CHECK(eight.leads_through(23));
  CHECK(eight.leads_through(24));
  CHECK(eight.inflation.cost().at({30, 23}) == kInscribedCost);
  CHECK(eight.tight.cost().at({30, 23}) == TightPlaces::kTightCost);
  const Floor nine(9);  // through the middle of the middle cell, as ever
  CHECK(nine.leads_through(24));
  CHECK(nine.tight.cost().at({30, 24}) < TightPlaces::kTightCost);
}

TEST_CASE("elsewhere costs are the inflation's, and what is unknown is nowhere to stand") {
  Floor floor(8);
  for (std::size_t i = 0; i < floor.states.cells.size(); ++i) {
    const std::uint8_t inflated = floor.inflation.cost().cells[i];
    if (inflated != kInscribedCost) REQUIRE(floor.tight.cost().cells[i] == inflated);
  }
  const std::uint32_t cell = static_cast<std::uint32_t>(floor.states.index({30, 23}));
  floor.states.cells[cell] = CellState::unknown;
  floor.update(std::span(&cell, 1));
  CHECK(floor.tight.cost().cells[cell] == kInscribedCost);
  floor.states.cells[cell] = CellState::free;
  floor.update(std::span(&cell, 1));
  CHECK(floor.tight.cost().cells[cell] == TightPlaces::kTightCost);
}

TEST_CASE("where it has been it can be again, unless something stands nearer than its own radius") {
  Floor floor(7);
  floor.tight.tread(floor.states, floor.inflation, 1.525, 1.175);  // cell (30, 23), the middle
  REQUIRE(floor.tight.changed_cells().size() == 1);
  CHECK(floor.tight.cost().at({30, 23}) == TightPlaces::kTightCost);
  floor.tight.tread(floor.states, floor.inflation, 1.525, 1.175);
  CHECK(floor.tight.changed_cells().empty());
  const std::uint32_t person = static_cast<std::uint32_t>(floor.states.index({30, 26}));
  floor.states.cells[person] = CellState::occupied;
  floor.update(std::span(&person, 1));
  CHECK(floor.tight.cost().at({30, 23}) == kInscribedCost);
}

TEST_CASE("kept from changes, the costs are those of a fresh look, and every change is named") {
  tests::Random random(11);
  Floor kept;
  for (int step = 0; step < 60; ++step) {
    std::vector<std::uint32_t> changed;
    for (int n = 0; n < 12; ++n) {
      const std::uint32_t i = random.below(static_cast<std::uint32_t>(kept.states.cells.size()));
      const std::uint32_t kind = random.below(12);
      kept.states.cells[i] = kind == 0 ? CellState::occupied : kind == 1 ? CellState::unknown : CellState::free;
      changed.push_back(i);
    }
    const std::vector<std::uint8_t> before = kept.tight.cost().cells;
    kept.update(changed);
    Floor fresh;
    fresh.states = kept.states;
    std::vector<std::uint32_t> all(fresh.states.cells.size());
    for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    fresh.update(all);
    REQUIRE(kept.tight.cost().cells == fresh.tight.cost().cells);
    std::vector<std::uint32_t> named(kept.tight.changed_cells().begin(), kept.tight.changed_cells().end());
    std::sort(named.begin(), named.end());
    REQUIRE(std::adjacent_find(named.begin(), named.end()) == named.end());
    for (std::uint32_t i = 0; i < before.size(); ++i) {
      const bool is_named = std::binary_search(named.begin(), named.end(), i);
      REQUIRE(is_named == (before[i] != kept.tight.cost().cells[i]));
    }
  }
}
