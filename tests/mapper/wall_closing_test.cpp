// SPDX-License-Identifier: Apache-2.0
// Thin walls that are turned: nothing gets through that could not before, and they do not become two.
#include "mapper/wall_closing.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <vector>

#include "mapper/map_sampler.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

constexpr int kReach = 20;  // voxels from the middle of the grid
constexpr Rgbo kFreeCode = 4;
constexpr Rgbo kWallCode = 28;

using Shape = std::function<double(double, double, double)>;  ///< signed distance in voxels

/// As thin as walls can be: voxels inside of the shape one face of which is outside. Free air on both sides.
std::unique_ptr<VoxelMap> thin_shell(const Shape& distance) {
  auto map = std::make_unique<VoxelMap>(Grid{0.05F}, MapCapacity{4096, 4096, 8});
  const int reach = kReach + 16;
  const auto at = [&](int x, int y, int z) { return distance(x - 32768 + 0.5, y - 32768 + 0.5, z - 32768 + 0.5); };
  for (int bz = 32768 - reach; bz < 32768 + reach; bz += 8) {
    for (int by = 32768 - reach; by < 32768 + reach; by += 8) {
      for (int bx = 32768 - reach; bx < 32768 + reach; bx += 8) {
        BlockValues values;
        const VoxelIndex origin = block_origin(block_of({bx, by, bz}));
        for (std::size_t i = 0; i < values.size(); ++i) {
          const VoxelIndex p = decode(i);
          const int x = origin.x + p.x;
          const int y = origin.y + p.y;
          const int z = origin.z + p.z;
          const bool is_wall =
              at(x, y, z) <= 0.0 && (at(x - 1, y, z) > 0.0 || at(x + 1, y, z) > 0.0 || at(x, y - 1, z) > 0.0 ||
                                     at(x, y + 1, z) > 0.0 || at(x, y, z - 1) > 0.0 || at(x, y, z + 1) > 0.0);
          values[i] = is_wall ? kWallCode : kFreeCode;
        }
        REQUIRE(map->write_block(block_of({bx, by, bz}), values));
      }
    }
  }
  return map;
}

/// What the sampler makes of it, for |k| < kReach around the middle.
std::unique_ptr<VoxelMap> turned_shell(const VoxelMap& map, const hal::Pose& T_world_map, Walls walls) {
  auto result = std::make_unique<VoxelMap>(map.grid(), MapCapacity{1U << 15, 1U << 15, 8});
  MapSampler sampler(map, T_world_map, map.grid(), {}, walls);
  std::vector<BlockKey> keys;
  sampler.add_target_keys(keys);
  sort_and_drop_repeats(keys);
  BlockValues values;
  for (const BlockKey key : keys) {
    sampler.sample(key, values);
    REQUIRE(result->write_block(key, values));
  }
  return result;
}

hal::Pose turn_of_chance(tests::Random& random) {
  return hal::from_xyz_rpy(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1),
                           random.uniform(-3.2, 3.2), random.uniform(-1.5, 1.5), random.uniform(-3.2, 3.2));
}

/// From the middle face by face through all that is not occupied: how many voxels beyond `most` voxels it comes to.
std::size_t escaped(const VoxelMap& map, double most) {
  constexpr int kSide = 2 * kReach;
  std::vector<bool> seen(kSide * kSide * kSide);
  std::vector<std::array<int, 3>> open{{kReach, kReach, kReach}};
  const auto n = [](const std::array<int, 3>& p) {
    return static_cast<std::size_t>((p[2] * kSide + p[1]) * kSide + p[0]);
  };
  seen[n(open[0])] = true;
  std::size_t out = 0;
  while (!open.empty()) {
    const auto p = open.back();
    open.pop_back();
    const double x = p[0] - kReach + 0.5;
    const double y = p[1] - kReach + 0.5;
    const double z = p[2] - kReach + 0.5;
    if (std::sqrt(x * x + y * y + z * z) > most) {
      ++out;
      continue;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const int step : {-1, 1}) {
        auto q = p;
        q[axis] += step;
        if (q[axis] < 0 || q[axis] >= kSide || seen[n(q)]) continue;
        if (state_of(map.at(VoxelIndex{32768 - kReach + q[0], 32768 - kReach + q[1], 32768 - kReach + q[2]})) ==
            State::occupied)
          continue;
        seen[n(q)] = true;
        open.push_back(q);
      }
    }
  }
  return out;
}

struct Thickness {
  std::uint64_t rays = 0;
  std::uint64_t open = 0;     ///< through which nothing stood
  std::uint64_t doubled = 0;  ///< that met the wall, air, and the wall again
  std::uint64_t voxels = 0;   ///< of wall, all rays together
};

/// Along the voxels' columns through a wall across them.
Thickness thickness_of(const VoxelMap& map, int axis) {
  Thickness result;
  for (int a = -12; a < 12; ++a) {
    for (int b = -12; b < 12; ++b) {
      int parts = 0;
      bool was = false;
      for (int c = -kReach; c < kReach; ++c) {
        const VoxelIndex v = axis == 0   ? VoxelIndex{32768 + c, 32768 + a, 32768 + b}
                             : axis == 1 ? VoxelIndex{32768 + a, 32768 + c, 32768 + b}
                                         : VoxelIndex{32768 + a, 32768 + b, 32768 + c};
        const bool is = state_of(map.at(v)) == State::occupied;
        parts += is && !was ? 1 : 0;
        result.voxels += is ? 1 : 0;
        was = is;
      }
      ++result.rays;
      result.open += parts == 0 ? 1 : 0;
      result.doubled += parts > 1 ? 1 : 0;
    }
  }
  return result;
}

}  // namespace

TEST_CASE("what a thin shell encloses stays enclosed however it is turned", "[mapper][merge][slow]") {
  tests::Random random(3);
  std::size_t leaks_without = 0;
  for (int trial = 0; trial < 6; ++trial) {
    // A ball, or a box that stands askew in its own map.
    const hal::Pose askew = hal::inverse(turn_of_chance(random));
    const Shape ball = [](double x, double y, double z) { return std::sqrt(x * x + y * y + z * z) - 9.3; };
    const Shape box = [&](double x, double y, double z) {
      const auto p = hal::compose(askew, {{x, y, z}, {0, 0, 0, 1}}).translation_m;
      return std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])}) - 7.2;
    };
    const auto map = thin_shell(trial % 2 == 0 ? ball : box);
    REQUIRE(escaped(*map, 16.0) == 0);
    const hal::Pose T_world_map = turn_of_chance(random);
    leaks_without += escaped(*turned_shell(*map, T_world_map, Walls::as_centres_say), 16.0);
    CHECK(escaped(*turned_shell(*map, T_world_map, Walls::closed), 16.0) == 0);
  }
  CHECK(leaks_without > 0);  // else this would show nothing
}

TEST_CASE("a thin wall that is turned has no holes, does not become two, and hardly thicker", "[mapper][merge][slow]") {
  tests::Random random(8);
  Thickness before;
  Thickness plain;
  Thickness closed;
  const auto add = [](Thickness& sum, const Thickness& one) {
    sum.rays += one.rays;
    sum.open += one.open;
    sum.doubled += one.doubled;
    sum.voxels += one.voxels;
  };
  for (int trial = 0; trial < 12; ++trial) {
    // A plane whose normal is nearest to an axis that both maps share, so that columns go across it in both.
    const double nx = random.uniform(-0.7, 0.7);
    const double ny = random.uniform(-0.7, 0.7);
    const auto map = thin_shell([&](double x, double y, double z) { return nx * x + ny * y + z; });
    const double turn = trial % 3 == 0 ? 0.785398 : random.uniform(-3.2, 3.2);
    const hal::Pose T_world_map =
        hal::from_xyz_rpy(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1),
                          random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), turn);
    add(before, thickness_of(*map, 2));
    add(plain, thickness_of(*turned_shell(*map, T_world_map, Walls::as_centres_say), 2));
    add(closed, thickness_of(*turned_shell(*map, T_world_map, Walls::closed), 2));
  }
  const auto per_ray = [](const Thickness& t) { return static_cast<double>(t.voxels) / static_cast<double>(t.rays); };
  INFO("rays " << closed.rays << ", open " << before.open << " / " << plain.open << " / " << closed.open << ", doubled "
               << before.doubled << " / " << plain.doubled << " / " << closed.doubled << ", thickness "
               << per_ray(before) << " / " << per_ray(plain) << " / " << per_ray(closed)
               << " voxels (own map, by centres, closed)");
  CHECK(before.open + before.doubled == 0);
  CHECK(plain.open > 0);
  CHECK(closed.open == 0);
  CHECK(closed.doubled <= closed.rays / 1000);
  CHECK(per_ray(closed) < 1.35 * per_ray(before));
}
