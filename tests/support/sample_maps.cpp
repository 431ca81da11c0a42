// SPDX-License-Identifier: Apache-2.0
#include "tests/support/sample_maps.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace g3d::tests {

using mapper::BlockKey;
using mapper::BlockValues;
using mapper::Grid;
using mapper::Rgbo;
using mapper::VoxelIndex;
using mapper::VoxelMap;

std::uint64_t Random::next() {
  std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ULL);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31);
}

namespace {

Rgbo coloured_code(Rgbo rgb, std::uint8_t level) {
  return (rgb << 8) | level | (level > mapper::kUnknownLevel ? mapper::kHasColourBit : 0U);
}

BlockValues random_block(Random& random, bool coloured) {
  BlockValues values;
  const std::uint32_t kind = random.below(6);
  const auto base = static_cast<std::uint8_t>(random.below(33));
  const auto rgb = static_cast<Rgbo>(random.below(1U << 24));
  const int edge = static_cast<int>(random.below(8));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const VoxelIndex v = mapper::decode(i);
    std::uint8_t level = base;
    if (kind == 2) level = static_cast<std::uint8_t>(random.below(33));                                    // noise
    if (kind >= 3) level = static_cast<std::uint8_t>(v.z < edge ? 16 : v.z == edge ? 32 : 2 * (v.x / 4));  // a floor
    if (kind == 4 && random.below(20) == 0) level = static_cast<std::uint8_t>(random.below(33));
    const bool with_colour = coloured && kind >= 2 && kind != 5 && random.below(10) != 0;
    values[i] = with_colour && level > mapper::kUnknownLevel ? coloured_code((rgb + random.below(7)) & 0xFFFFFFU, level)
                                                             : level;
  }
  if (kind == 5 && coloured) values[7] = coloured_code(0, 20);  // one voxel, and it is black
  return values;
}

struct Solid {
  enum class Shape { box, ball, pole } shape;
  std::array<double, 3> low_or_centre;
  std::array<double, 3> high_or_radius;  ///< ball: radius; pole: radius, z_low, z_high
  Rgbo rgb;
  [[nodiscard]] bool contains(double x, double y, double z) const {
    const auto& a = low_or_centre;
    const auto& b = high_or_radius;
    switch (shape) {
      case Shape::box:
        return x >= a[0] && x <= b[0] && y >= a[1] && y <= b[1] && z >= a[2] && z <= b[2];
      case Shape::ball:
        return std::pow(x - a[0], 2) + std::pow(y - a[1], 2) + std::pow(z - a[2], 2) <= b[0] * b[0];
      case Shape::pole:
        return std::pow(x - a[0], 2) + std::pow(y - a[1], 2) <= b[0] * b[0] && z >= b[1] && z <= b[2];
    }
    return false;
  }
};

std::vector<Solid> furniture() {
  std::vector<Solid> all;
  const auto box = [&](double x0, double y0, double z0, double x1, double y1, double z1, Rgbo rgb) {
    all.push_back({Solid::Shape::box, {x0, y0, z0}, {x1, y1, z1}, rgb});
  };
  const auto pole = [&](double x, double y, double r, double z0, double z1, Rgbo rgb) {
    all.push_back({Solid::Shape::pole, {x, y, 0}, {r, z0, z1}, rgb});
  };
  box(-3.2, -2.7, -0.2, 3.2, 2.7, 0.0, 0xB08A5C);  // floor
  box(-3.2, -2.7, 2.5, 3.2, 2.7, 2.7, 0xF0F0EC);   // ceiling
  box(-3.2, -2.7, 0, -3.0, 2.7, 2.5, 0xE6DCC8);    // walls
  box(3.0, -2.7, 0, 3.2, 0.8, 2.5, 0xE6DCC8);
  box(3.0, 1.7, 0, 3.2, 2.7, 2.5, 0xE6DCC8);  // a door between
  box(3.0, 0.8, 2.0, 3.2, 1.7, 2.5, 0xE6DCC8);
  box(-3.2, -2.7, 0, 3.2, -2.5, 2.5, 0xB9CBD6);
  box(-3.2, 2.5, 0, 3.2, 2.7, 2.5, 0xB9CBD6);
  box(-0.8, -0.5, 0.68, 0.8, 0.4, 0.76, 0x8A4F24);  // table
  for (const double x : {-0.72, 0.72}) {
    for (const double y : {-0.42, 0.32}) pole(x, y, 0.04, 0.0, 0.7, 0x5A3418);
  }
  box(-0.25, -1.2, 0.42, 0.25, -0.75, 0.47, 0x2F6B3A);  // chair
  box(-0.25, -1.25, 0.47, 0.25, -1.2, 0.95, 0x2F6B3A);
  for (const double x : {-0.21, 0.21}) {
    for (const double y : {-1.18, -0.79}) pole(x, y, 0.025, 0.0, 0.42, 0x1E4526);
  }
  box(-2.9, -1.2, 0.0, -2.1, 1.0, 0.42, 0xB23A35);  // sofa
  box(-3.0, -1.2, 0.42, -2.75, 1.0, 0.85, 0x9C302C);
  box(-2.9, -1.4, 0.0, -2.1, -1.2, 0.6, 0x9C302C);
  box(-2.9, 1.0, 0.0, -2.1, 1.2, 0.6, 0x9C302C);
  for (int shelf = 0; shelf < 5; ++shelf) box(0.6, 2.15, 0.4 * shelf, 2.2, 2.5, 0.4 * shelf + 0.04, 0x7B5B3A);
  box(0.56, 2.15, 0.0, 0.6, 2.5, 1.64, 0x7B5B3A);
  box(2.2, 2.15, 0.0, 2.24, 2.5, 1.64, 0x7B5B3A);
  for (int book = 0; book < 14; ++book) {
    const double x = 0.66 + 0.1 * book;
    box(x, 2.25, 0.44 + 0.4 * (book % 3), x + 0.06, 2.45, 0.68 + 0.4 * (book % 3),
        0x203050U + 0x0B2F17U * static_cast<Rgbo>(book));
  }
  pole(2.4, -1.9, 0.16, 0.0, 0.03, 0x303030);  // lamp
  pole(2.4, -1.9, 0.02, 0.0, 1.5, 0x303030);
  pole(2.4, -1.9, 0.18, 1.5, 1.75, 0xF2D16B);
  all.push_back({Solid::Shape::ball, {1.6, -1.2, 0.2}, {0.2, 0, 0}, 0x2C5FC4});
  return all;
}

/// 0xRRGGBB of the solid at a point, or -1 in the air, -2 outside of the house.
int material(const std::vector<Solid>& solids, double x, double y, double z) {
  if (std::abs(x) > 3.2 || std::abs(y) > 2.7 || z < -0.2 || z > 2.7) return -2;
  for (const Solid& solid : solids) {
    if (solid.contains(x, y, z)) return static_cast<int>(solid.rgb);
  }
  return -1;
}

Rgbo shaded(int rgb, int step) {
  Rgbo out = 0;
  for (int shift = 16; shift >= 0; shift -= 8)
    out = (out << 8) | static_cast<Rgbo>(std::clamp(((rgb >> shift) & 0xFF) + step, 0, 255));
  return out;
}

}  // namespace

std::unique_ptr<VoxelMap> random_map(std::uint64_t seed, int blocks, float resolution_m, bool coloured) {
  Random random(seed);
  const auto count = static_cast<std::uint32_t>(blocks) + 8U;
  auto map = std::make_unique<VoxelMap>(Grid{resolution_m}, mapper::MapCapacity{count, count, 8 * count});
  const auto side = static_cast<std::uint32_t>(std::cbrt(2.0 * blocks)) + 2U;
  const auto near_middle = [&] {
    return 32768 + 8 * (static_cast<int>(random.below(side)) - static_cast<int>(side / 2));
  };
  for (int i = 0; i < blocks; ++i) {
    VoxelIndex v{near_middle(), near_middle(), near_middle()};
    if (random.below(50) == 0)
      v = {static_cast<int>(random.below(65536)), static_cast<int>(random.below(65536)), 65535};
    if (i == 0) v = {0, 0, 0};
    if (i == 1) v = {65535, 65535, 65535};
    map->write_block(mapper::block_of(v), random_block(random, coloured));
  }
  return map;
}

std::unique_ptr<VoxelMap> furnished_room(float resolution_m, bool free_space) {
  const std::vector<Solid> solids = furniture();
  const Grid grid{resolution_m};
  auto map = std::make_unique<VoxelMap>(grid, mapper::MapCapacity{1U << 20, 1U << 19, 1U << 20});
  Random random(7);
  const VoxelIndex low = grid.to_index(-3.3F, -2.8F, -0.3F);
  const VoxelIndex high = grid.to_index(3.3F, 2.8F, 2.8F);
  const double r = resolution_m;
  for (int bz = low.z & ~7; bz <= high.z; bz += 8) {
    for (int by = low.y & ~7; by <= high.y; by += 8) {
      for (int bx = low.x & ~7; bx <= high.x; bx += 8) {
        BlockValues values;
        bool known = false;
        for (std::size_t i = 0; i < values.size(); ++i) {
          const VoxelIndex v = mapper::decode(i);
          const auto p = grid.centre_m(VoxelIndex{bx + v.x, by + v.y, bz + v.z});
          const int own = material(solids, p[0], p[1], p[2]);
          values[i] = mapper::kUnknownRgbo;
          if (own == -1 && free_space) values[i] = random.below(40) == 0 ? 2 : 0;
          if (own >= 0) {
            const bool seen =
                material(solids, p[0] - r, p[1], p[2]) == -1 || material(solids, p[0] + r, p[1], p[2]) == -1 ||
                material(solids, p[0], p[1] - r, p[2]) == -1 || material(solids, p[0], p[1] + r, p[2]) == -1 ||
                material(solids, p[0], p[1], p[2] - r) == -1 || material(solids, p[0], p[1], p[2] + r) == -1;
            const int grain = static_cast<int>(random.below(9)) - 4;
            if (seen)
              values[i] = coloured_code(shaded(own, grain), static_cast<std::uint8_t>(random.below(8) == 0 ? 28 : 32));
          }
          known = known || values[i] != mapper::kUnknownRgbo;
        }
        if (known) map->write_block(mapper::block_of({bx, by, bz}), values);
      }
    }
  }
  return map;
}

bool same_map(const VoxelMap& a, const VoxelMap& b) {
  const std::vector<BlockKey> keys = a.sorted_keys();
  if (!(a.grid() == b.grid()) || keys != b.sorted_keys()) return false;
  BlockValues in_a;
  BlockValues in_b;
  return std::all_of(keys.begin(), keys.end(), [&](BlockKey key) {
    return a.read_stored_block(key, in_a) && b.read_stored_block(key, in_b) && in_a == in_b;
  });
}

}  // namespace g3d::tests
