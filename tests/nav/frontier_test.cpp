// SPDX-License-Identifier: Apache-2.0
#include "nav/frontier.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::nav;

namespace {

using Ground = CellGrid<CellState>;

bool is_frontier_by_definition(const Ground& ground, Cell c) {
  if (ground.at(c) != CellState::free) return false;
  for (const Cell n : {Cell{c.x - 1, c.y}, Cell{c.x + 1, c.y}, Cell{c.x, c.y - 1}, Cell{c.x, c.y + 1}}) {
    if (ground.contains(n) && ground.at(n) == CellState::unknown) return true;
  }
  return false;
}

std::vector<std::vector<std::uint32_t>> clusters_of(FrontierMap& map) {
  map.make_clusters();
  std::vector<std::vector<std::uint32_t>> out;
  for (const FrontierCluster& cluster : map.clusters()) {
    const auto cells = map.cells_of(cluster);
    out.emplace_back(cells.begin(), cells.end());
  }
  return out;
}

}  // namespace

TEST_CASE("frontiers kept from changes equal those of a fresh look at every step") {
  tests::Random random(5);
  Ground ground(0.05, -1.0, 2.0, 37, 23, CellState::unknown);
  FrontierMap kept;
  kept.reset(ground);
  for (int step = 0; step < 300; ++step) {
    std::vector<std::uint32_t> changed;
    for (std::uint32_t n = random.below(30); n > 0; --n) {
      const std::uint32_t i = random.below(static_cast<std::uint32_t>(ground.cells.size()));
      ground.cells[i] = static_cast<CellState>(random.below(3));
      changed.push_back(i);
    }
    kept.update(ground, changed);
    FrontierMap fresh;
    fresh.reset(ground);
    for (std::size_t i = 0; i < ground.cells.size(); ++i) {
      REQUIRE(kept.is_frontier(i) == is_frontier_by_definition(ground, ground.cell(i)));
    }
    REQUIRE(kept.cells().size() == fresh.cells().size());
    REQUIRE(clusters_of(kept) == clusters_of(fresh));
  }
}

TEST_CASE("clusters join over corners and stand in the order of their lowest cell") {
  Ground ground(0.05, 0.0, 0.0, 12, 6, CellState::occupied);
  const auto pocket = [&](Cell free, Cell unknown) {
    ground.at(free) = CellState::free;
    ground.at(unknown) = CellState::unknown;
  };
  pocket({9, 1}, {10, 1});
  pocket({1, 2}, {0, 2});
  pocket({2, 3}, {2, 4});
  FrontierMap map;
  map.reset(ground);
  map.make_clusters();
  REQUIRE(map.clusters().size() == 2);
  CHECK(map.cells_of(map.clusters()[0])[0] == ground.index({9, 1}));
  CHECK(map.clusters()[1].count == 2);
}
