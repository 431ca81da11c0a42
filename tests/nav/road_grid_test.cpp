// SPDX-License-Identifier: Apache-2.0
#include "nav/road_grid.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <span>
#include <vector>

#include "tests/support/flat_sim.hpp"
#include "tests/support/flat_world.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::nav;

namespace {

using Costs = CellGrid<std::uint8_t>;
constexpr std::int32_t kAll = TravelField::kNever - 100;

Costs two_rooms(int wall_cells) {
  tests::FlatWorld world;
  world.solid = Costs(0.05, 0.0, 0.0, 90, 40, 0);
  for (int y = 0; y < 40; ++y) {
    for (int x = 40; x < 40 + wall_cells; ++x) world.solid.at({x, y}) = 1;
  }
  return tests::true_costs(world.solid);
}

/// Per map cell the lowest cell that it is connected to, side by side, without leaving its road cell (`within` true) or
/// at all.
std::vector<std::uint32_t> plain_pieces(const Costs& costs, const RoadGrid& roads, bool within) {
  constexpr std::uint32_t kNone = 0xFFFFFFFF;
  std::vector<std::uint32_t> piece(costs.cells.size(), kNone);
  for (std::uint32_t first = 0; first < piece.size(); ++first) {
    if (costs.cells[first] >= kInscribedCost || piece[first] != kNone) continue;
    std::vector<std::uint32_t> queue{first};
    piece[first] = first;
    for (std::size_t k = 0; k < queue.size(); ++k) {
      const Cell c = costs.cell(queue[k]);
      for (const Cell n : {Cell{c.x + 1, c.y}, Cell{c.x - 1, c.y}, Cell{c.x, c.y + 1}, Cell{c.x, c.y - 1}}) {
        if (!costs.contains(n) || costs.at(n) >= kInscribedCost || piece[costs.index(n)] != kNone) continue;
        if (within && roads.road_of(n) != roads.road_of(c)) continue;
        piece[costs.index(n)] = first;
        queue.push_back(static_cast<std::uint32_t>(costs.index(n)));
      }
    }
  }
  return piece;
}

/// Per road cell its largest piece.
std::vector<std::uint32_t> plain_largest(const Costs& costs, const RoadGrid& roads) {
  const std::vector<std::uint32_t> piece = plain_pieces(costs, roads, true);
  std::map<std::uint32_t, int> size;
  for (const std::uint32_t p : piece) ++size[p];
  std::vector<std::uint32_t> largest(roads.size(), 0xFFFFFFFF);
  for (std::size_t i = 0; i < piece.size(); ++i) {
    if (costs.cells[i] >= kInscribedCost) continue;
    std::uint32_t& best = largest[roads.road_of(costs.cell(i))];
    if (best == 0xFFFFFFFF || size[piece[i]] > size[best]) best = piece[i];
  }
  return largest;
}

std::size_t next_to(std::size_t road, std::size_t direction, const RoadGrid& roads) {
  const std::size_t columns = static_cast<std::size_t>(roads.columns());
  return direction == 0 ? road + 1 : direction == 1 ? road + columns : direction == 2 ? road - 1 : road - columns;
}

/// In the directions east, north, west and south: whether the largest pieces share a side.
std::vector<std::array<bool, 4>> plainly_joined(const Costs& costs, const RoadGrid& roads) {
  const std::vector<std::uint32_t> piece = plain_pieces(costs, roads, true);
  const std::vector<std::uint32_t> largest = plain_largest(costs, roads);
  std::vector<std::array<bool, 4>> joined(roads.size(), {false, false, false, false});
  for (std::size_t i = 0; i < piece.size(); ++i) {
    const Cell c = costs.cell(i);
    const std::array<Cell, 4> beside{Cell{c.x + 1, c.y}, {c.x, c.y + 1}, {c.x - 1, c.y}, {c.x, c.y - 1}};
    for (std::size_t d = 0; d < 4; ++d) {
      if (!costs.contains(beside[d]) || roads.road_of(beside[d]) == roads.road_of(c)) continue;
      const std::size_t n = costs.index(beside[d]);
      if (costs.cells[i] >= kInscribedCost || costs.cells[n] >= kInscribedCost) continue;
      if (piece[i] != largest[roads.road_of(c)] || piece[n] != largest[roads.road_of(beside[d])]) continue;
      joined[roads.road_of(c)][d] = true;
    }
  }
  return joined;
}

/// A floor with many narrow places, some of them closed by a cell or two.
Costs littered_floor(tests::Random& random) {
  tests::FlatWorld world;
  world.solid = Costs(0.05, 0.0, 0.0, 90, 70, 0);
  for (int n = 0; n < 60; ++n) {
    world.solid.at({static_cast<int>(random.below(90)), static_cast<int>(random.below(70))}) = 1;
  }
  Costs costs = tests::true_costs(world.solid);
  for (int n = 0; n < 150; ++n) costs.cells[random.below(90 * 70)] = kUnknownCost;
  return costs;
}

}  // namespace

TEST_CASE("no road leads through a wall of one cell") {
  for (int shift = 0; shift < 6; ++shift) {
    Costs costs(0.05, 0.0, 0.0, 90, 40, 0);
    const Costs walled = two_rooms(1);
    for (int y = 0; y < 40; ++y) {
      for (int x = shift; x < 90; ++x) costs.at({x, y}) = walled.at({x - shift, y});
    }
    RoadGrid roads;
    roads.reset(costs, 0.18);
    TravelField field;
    roads.size_field(field);
    roads.travel(roads.road_of({10, 20}), kAll, field);
    CHECK(field.distance[roads.road_of({20, 10})] != TravelField::kNever);
    CHECK(field.distance[roads.road_of({70, 20})] == TravelField::kNever);
  }
}

TEST_CASE("distances are those of the shortest ways, and a limit cuts them off") {
  const Costs costs = tests::true_costs(tests::make_flat_world("maze", 3).solid);
  RoadGrid roads;
  roads.reset(costs, 0.18);
  std::uint32_t from = 0;
  while (!roads.is_open(from)) ++from;
  TravelField field;
  roads.size_field(field);
  roads.travel(from, kAll, field);
  // Bellman and Ford: relax until nothing changes.
  const std::vector<std::array<bool, 4>> joined = plainly_joined(costs, roads);
  std::vector<std::int64_t> plain(roads.size(), 1'000'000'000);
  plain[from] = 0;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t at = 0; at < roads.size(); ++at) {
      const auto relax = [&](std::size_t to, int tenths) {
        if (plain[at] + tenths >= plain[to]) return;
        plain[to] = plain[at] + tenths;
        changed = true;
      };
      for (std::size_t d = 0; d < 4; ++d) {
        if (!joined[at][d]) continue;
        const std::size_t beside = next_to(at, d, roads);
        relax(beside, 10);
        for (const std::size_t turn : {(d + 1) % 4, (d + 3) % 4}) {
          if (joined[beside][turn]) relax(next_to(beside, turn, roads), 14);
        }
      }
    }
  }
  std::size_t reached = 0;
  for (std::size_t i = 0; i < roads.size(); ++i) {
    const bool never = field.distance[i] == TravelField::kNever;
    REQUIRE(never == (plain[i] == 1'000'000'000));
    if (!never) REQUIRE(field.distance[i] == plain[i]);
    reached += !never;
  }
  CHECK(field.reached.size() == reached);

  roads.travel(from, 100, field);
  for (std::size_t i = 0; i < roads.size(); ++i) {
    REQUIRE((field.distance[i] != TravelField::kNever) == (plain[i] <= 100));
  }
}

TEST_CASE("roads kept from changes equal those of a fresh look") {
  tests::Random random(9);
  Costs costs(0.05, 0.0, 0.0, 50, 41, kUnknownCost);
  RoadGrid kept;
  kept.reset(costs, 0.18);
  for (int step = 0; step < 100; ++step) {
    std::vector<std::uint32_t> changed;
    for (int n = 0; n < 20; ++n) {
      const std::uint32_t i = random.below(static_cast<std::uint32_t>(costs.cells.size()));
      costs.cells[i] = static_cast<std::uint8_t>(random.below(256));
      changed.push_back(i);
    }
    kept.update(costs, changed);
    RoadGrid fresh;
    fresh.reset(costs, 0.18);
    TravelField by_kept;
    TravelField by_fresh;
    kept.size_field(by_kept);
    fresh.size_field(by_fresh);
    const std::uint32_t from = random.below(static_cast<std::uint32_t>(kept.size()));
    kept.travel(from, kAll, by_kept);
    fresh.travel(from, kAll, by_fresh);
    REQUIRE(by_kept.distance == by_fresh.distance);
    for (std::size_t i = 0; i < kept.size(); ++i) {
      REQUIRE(kept.is_open(i) == fresh.is_open(i));
      Cell a;
      Cell b;
      REQUIRE(kept.best_cell(costs, i, a) == fresh.best_cell(costs, i, b));
      REQUIRE(a == b);
    }
  }
}

TEST_CASE("a road leads only where the planner finds a way, be the gap ever so little too narrow") {
  tests::Random random(4);
  TravelField field;
  std::size_t reached = 0;
  std::size_t split = 0;
  for (int map = 0; map < 20; ++map) {
    const Costs costs = littered_floor(random);
    RoadGrid roads;
    roads.reset(costs, 0.18);
    roads.size_field(field);
    const std::vector<std::uint32_t> connected = plain_pieces(costs, roads, false);
    std::map<std::uint32_t, int> size;
    for (const std::uint32_t p : connected) ++size[p];
    size.erase(0xFFFFFFFF);
    const auto smaller = [](const auto& a, const auto& b) { return a.second < b.second; };
    const std::uint32_t piece = std::max_element(size.begin(), size.end(), smaller)->first;
    std::uint32_t from = 0;
    Cell start;
    while (!roads.best_cell(costs, from, start) || connected[costs.index(start)] != piece) ++from;
    roads.travel(from, kAll, field);
    for (const std::uint32_t road : field.reached) {
      Cell end;
      REQUIRE(roads.best_cell(costs, road, end));
      REQUIRE(connected[costs.index(end)] == piece);
    }
    reached += field.reached.size();
    // And what the planner reaches is reached, but for the smaller pieces of road cells that are split.
    const std::vector<std::uint32_t> within = plain_pieces(costs, roads, true);
    const std::vector<std::uint32_t> largest = plain_largest(costs, roads);
    for (std::size_t i = 0; i < connected.size(); ++i) {
      const std::uint32_t road = roads.road_of(costs.cell(i));
      if (connected[i] != piece || within[i] != largest[road]) continue;
      split += field.distance[road] == TravelField::kNever;
    }
  }
  CHECK(reached > 2000);
  CHECK(split * 50 < reached);
}

TEST_CASE("a gap between two rooms that is a cell too narrow is no road, a wider one is") {
  for (const bool is_open : {false, true}) {
    Costs costs = two_rooms(1);
    // Where the body may stand, the door is as deep as it is wide: nine cells. One cell in its middle closes it.
    for (int x = 30; x < 52; ++x) costs.at({x, 20}) = 100;
    if (!is_open) costs.at({40, 20}) = kInscribedCost;
    RoadGrid roads;
    roads.reset(costs, 0.18);
    TravelField field;
    roads.size_field(field);
    roads.travel(roads.road_of({10, 20}), kAll, field);
    CHECK((field.distance[roads.road_of({70, 20})] != TravelField::kNever) == is_open);
    // What opens and closes is followed.
    const std::uint32_t door = static_cast<std::uint32_t>(costs.index({40, 20}));
    costs.cells[door] = is_open ? kInscribedCost : std::uint8_t{100};
    roads.update(costs, std::span(&door, 1));
    roads.travel(roads.road_of({10, 20}), kAll, field);
    CHECK((field.distance[roads.road_of({70, 20})] != TravelField::kNever) == !is_open);
  }
}

TEST_CASE("a robot that is hemmed in is taken to get out to what is near") {
  Costs costs(0.05, 0.0, 0.0, 90, 40, 0);
  for (int i = 0; i < 10; ++i) {
    for (const Cell c : {Cell{20 + i, 10}, {20 + i, 19}, {20, 10 + i}, {29, 10 + i}}) costs.at(c) = kInscribedCost;
  }
  RoadGrid roads;
  roads.reset(costs, 0.18);
  TravelField field;
  roads.size_field(field);
  const std::uint32_t inside = roads.road_of({25, 14});
  roads.travel(inside, kAll, field);
  CHECK(field.reached.front() == inside);
  CHECK(field.distance[roads.road_of({70, 30})] != TravelField::kNever);
  // From outside nothing leads in.
  roads.travel(roads.road_of({70, 30}), kAll, field);
  CHECK(field.distance[inside] == TravelField::kNever);
}

TEST_CASE("ways say by which heading they leave and arrive") {
  Costs costs(0.05, 0.0, 0.0, 60, 60, kLethalCost);
  for (int i = 6; i < 51; ++i) {
    for (int w = 0; w < 6; ++w) {
      costs.at({i, 6 + w}) = 0;
      costs.at({45 + w, i}) = 0;
    }
  }
  RoadGrid roads;
  roads.reset(costs, 0.18);
  TravelField field;
  roads.size_field(field);
  const std::uint32_t from = roads.road_of({7, 9});
  const std::uint32_t to = roads.road_of({48, 49});
  roads.travel(from, kAll, field);
  CHECK(std::abs(roads.leave_heading(field, from, to)) < 0.4);
  CHECK(std::abs(roads.arrive_heading(field, to) - 1.5708) < 0.4);
  Cell best;
  REQUIRE(roads.best_cell(costs, from, best));
  CHECK(costs.at(best) == 0);
  CHECK_FALSE(roads.best_cell(costs, roads.road_of({30, 40}), best));
}

TEST_CASE("a robot that stands too near to something gets out again, but not through the wall") {
  Costs costs(0.05, 0.0, 0.0, 90, 40, 0);
  const Costs walled = two_rooms(1);
  for (int y = 0; y < 40; ++y) {
    for (int x = 1; x < 90; ++x) costs.at({x, y}) = walled.at({x - 1, y});
  }
  RoadGrid roads;
  roads.reset(costs, 0.18);
  TravelField field;
  roads.size_field(field);
  const std::uint32_t from = roads.road_of({39, 20});  // 10 cm before the wall
  REQUIRE_FALSE(roads.is_open(from));
  roads.travel(from, kAll, field);
  CHECK(field.reached.front() == from);
  CHECK(field.distance[roads.road_of({36, 20})] == 10);
  CHECK(field.distance[roads.road_of({10, 20})] != TravelField::kNever);
  CHECK(field.distance[roads.road_of({70, 20})] == TravelField::kNever);
}
