// SPDX-License-Identifier: Apache-2.0
// Maps made up for tests: random ones that reach every corner of the formats, and a furnished room that one can look
// at.
#pragma once

#include <cstdint>
#include <memory>

#include "mapper/voxel_map.hpp"

namespace g3d::tests {

/// Small, fast, the same everywhere (splitmix64).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next();
  /// 0 .. end - 1
  std::uint32_t below(std::uint32_t end) { return static_cast<std::uint32_t>(next() % end); }
  double uniform(double from, double to) {
    return from + (to - from) * (static_cast<double>(next() >> 11) * 0x1.0p-53);
  }

 private:
  std::uint64_t state_;
};

/// Uniform, smooth, noisy, coloured and uncoloured blocks, some at the grid's corners, in clusters around the middle.
std::unique_ptr<mapper::VoxelMap> random_map(std::uint64_t seed, int blocks, float resolution_m = 0.05F,
                                             bool coloured = true);

/// One room of 6 x 5 x 2.5 m with door, table, chair, sofa, shelf, lamp and ball; origin on the floor in its middle.
/// Shells of surfaces are occupied, the air is free, all behind is unknown; without `free_space` the air is unknown,
/// too.
std::unique_ptr<mapper::VoxelMap> furnished_room(float resolution_m, bool free_space = true);

/// Same keys, same stored values (colour bits included).
bool same_map(const mapper::VoxelMap& a, const mapper::VoxelMap& b);

}  // namespace g3d::tests
