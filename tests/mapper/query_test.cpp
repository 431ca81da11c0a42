// SPDX-License-Identifier: Apache-2.0
// Every query against a slow plain version on random maps.
#include "mapper/query.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

NodeState slow_node_state(const VoxelMap& map, MCode code, int levels_up) {
  const MCode count = MCode{1} << (3 * levels_up);
  const MCode first = code / count * count;
  std::array<bool, 3> seen{};
  for (MCode m = first; m < first + count; ++m) seen[static_cast<std::size_t>(state_of(map.at(m)))] = true;
  const int kinds = static_cast<int>(seen[0]) + static_cast<int>(seen[1]) + static_cast<int>(seen[2]);
  if (kinds > 1) return NodeState::mixed;
  return seen[0] ? NodeState::unknown : seen[1] ? NodeState::free : NodeState::occupied;
}

/// Distance at which a ray enters the cell of a voxel, infinite if it misses it.
double entry_m(const Grid& grid, const VoxelIndex& v, const std::array<double, 3>& origin,
               const std::array<double, 3>& unit) {
  const auto r = static_cast<double>(grid.resolution_m);
  const std::array<std::int32_t, 3> k{v.x, v.y, v.z};
  double in = 0;
  double out = std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double low = (k[axis] - 32768.0) * r;
    double a = (low - origin[axis]) / unit[axis];
    double b = (low + r - origin[axis]) / unit[axis];
    if (a > b) std::swap(a, b);
    in = std::max(in, a);
    out = std::min(out, b);
  }
  return in <= out ? in : std::numeric_limits<double>::infinity();
}

}  // namespace

TEST_CASE("A node says what all its voxels say") {
  const auto map = tests::random_map(81, 900);
  tests::Random random(82);
  std::array<int, 4> found{};
  for (int levels_up = 0; levels_up <= 6; ++levels_up) {
    for (int i = 0; i < (levels_up < 5 ? 400 : 20); ++i) {
      const VoxelIndex v{32768 + static_cast<int>(random.below(120)) - 60,
                         32768 + static_cast<int>(random.below(120)) - 60,
                         32768 + static_cast<int>(random.below(120)) - 60};
      const NodeState expected = slow_node_state(*map, encode(v), levels_up);
      REQUIRE(node_state(*map, encode(v), levels_up) == expected);
      ++found[static_cast<std::size_t>(expected)];
    }
  }
  for (const int count : found) CHECK(count > 10);
}

TEST_CASE("Nodes above the map are mixed, far ones unknown, full ones free") {
  VoxelMap map(Grid{0.05F}, {100, 4, 4});
  BlockValues values;
  values.fill(3);
  for (BlockKey key = 64; key < 128; ++key) REQUIRE(map.write_block(key, values));
  const MCode inside = 70ULL << kBlockShift;
  CHECK(node_state(map, inside, 4) == NodeState::free);
  CHECK(node_state(map, inside, 5) == NodeState::free);
  CHECK(node_state(map, inside, 6) == NodeState::mixed);
  CHECK(node_state(map, inside, 16) == NodeState::mixed);
  CHECK(node_state(map, MCode{1} << 47, 15) == NodeState::unknown);
  CHECK(std::string(to_string(NodeState::mixed)) == "mixed");
}

TEST_CASE("The state at a point is that of the voxel it falls into") {
  const auto map = tests::random_map(83, 300);
  tests::Random random(84);
  for (int i = 0; i < 2000; ++i) {
    const std::array<double, 3> p{random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)};
    const auto k = [](double x) { return 32767 + static_cast<int>(std::ceil(x / static_cast<double>(0.05F))); };
    REQUIRE(state_at(*map, p) == state_of(map->at(VoxelIndex{k(p[0]), k(p[1]), k(p[2])})));
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(state_at(*map, {nan, 0, 0}) == State::unknown);
  CHECK(state_at(*map, {1e30, 0, 0}) == State::unknown);
}

TEST_CASE("A ray finds the first occupied voxel of all that it passes") {
  const auto map = tests::random_map(85, 60);
  const VoxelBox middle{{32600, 32600, 32600}, {32900, 32900, 32900}};
  std::vector<VoxelIndex> occupied;
  for_each_known_in(*map, middle, [&](const VoxelIndex& v, Rgbo value) {
    if (state_of(value) == State::occupied) occupied.push_back(v);
  });
  REQUIRE(occupied.size() > 100);
  tests::Random random(86);
  int hits = 0;
  for (int i = 0; i < 200; ++i) {
    const std::array<double, 3> origin{random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)};
    std::array<double, 3> unit{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    const double length = std::sqrt(unit[0] * unit[0] + unit[1] * unit[1] + unit[2] * unit[2]);
    for (double& u : unit) u /= length;
    double nearest_m = 3.0;
    for (const VoxelIndex& v : occupied) nearest_m = std::min(nearest_m, entry_m(map->grid(), v, origin, unit));
    const RayHit hit = cast_ray(*map, origin, {2 * unit[0], 2 * unit[1], 2 * unit[2]}, {3.0, false});
    REQUIRE(hit.distance_m == Approx(nearest_m).margin(1e-6));
    REQUIRE((hit.end == RayEnd::occupied) == (nearest_m < 3.0));
    hits += hit.end == RayEnd::occupied ? 1 : 0;
    if (hit.end == RayEnd::occupied) REQUIRE(state_of(map->at(hit.voxel)) == State::occupied);
  }
  CHECK(hits > 20);
}

TEST_CASE("A ray ends at the unknown, at its range and at the end of the grid") {
  const auto room = tests::furnished_room(0.1F);
  const RayHit wall = cast_ray(*room, {-2.0, 2.05, 1.0}, {-1, 0, 0}, {10.0, true});
  CHECK(wall.end == RayEnd::occupied);
  CHECK(wall.distance_m == Approx(1.0).margin(0.11));
  const RayHit door = cast_ray(*room, {0.0, 1.25, 1.0}, {1, 0, 0}, {10.0, true});
  CHECK(door.end == RayEnd::unknown);
  CHECK(door.distance_m == Approx(3.2).margin(0.11));
  const RayHit none = cast_ray(*room, {0.0, 1.25, 1.0}, {1, 0, 0}, {2.0, true});
  CHECK(none.end == RayEnd::max_range);
  CHECK(none.distance_m == 2.0);
  CHECK(cast_ray(*room, {0.0, 1.25, 1.0}, {1, 0, 0}, {1e5, false}).end == RayEnd::left_grid);
  CHECK(cast_ray(*room, {0, 0, 1}, {0, 0, 0}).end == RayEnd::max_range);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(cast_ray(*room, {0, 0, 1}, {nan, 0, 0}).end == RayEnd::max_range);
  CHECK(cast_ray(*room, {nan, 0, 1}, {1, 0, 0}).end == RayEnd::left_grid);
}

TEST_CASE("A box holds exactly the known voxels whose centres lie in it") {
  const auto map = tests::random_map(87, 400);
  tests::Random random(88);
  for (int i = 0; i < 20; ++i) {
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.low_m[axis] = random.uniform(-1.0, 0.8);
      box.high_m[axis] = box.low_m[axis] + random.uniform(0.0, 0.9);
    }
    BoxCounts expected;
    for (int x = 32740; x < 32810; ++x) {
      for (int y = 32740; y < 32810; ++y) {
        for (int z = 32740; z < 32810; ++z) {
          const auto c = map->grid().centre_m(VoxelIndex{x, y, z});
          bool inside = true;
          for (std::size_t axis = 0; axis < 3; ++axis)
            inside = inside && c[axis] >= box.low_m[axis] && c[axis] <= box.high_m[axis];
          if (!inside) continue;
          const State state = state_of(map->at(VoxelIndex{x, y, z}));
          ++(state == State::occupied ? expected.occupied : state == State::free ? expected.free : expected.unknown);
        }
      }
    }
    const VoxelBox voxels = voxels_in(map->grid(), box);
    const BoxCounts counts = counts_in(*map, voxels);
    REQUIRE(counts.occupied == expected.occupied);
    REQUIRE(counts.free == expected.free);
    REQUIRE(counts.unknown == expected.unknown);
    MCode last = 0;
    for_each_known_in(*map, voxels, [&](const VoxelIndex& v, Rgbo value) {
      REQUIRE(encode(v) >= last);
      REQUIRE(value == map->at(v));
      last = encode(v);
    });
  }
  const BoxCounts all = counts_in(*map, voxels_in(map->grid(), {{-1e9, -1e9, -1e9}, {1e9, 1e9, 1e9}}));
  CHECK(all.occupied == map->counts().occupied);
  CHECK(all.free == map->counts().free);
  CHECK(counts_in(*map, voxels_in(map->grid(), {{1, 1, 1}, {0, 2, 2}})).unknown == 0);
}
