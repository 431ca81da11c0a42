// SPDX-License-Identifier: Apache-2.0
// What a neighbour's level means for the next voxel, in ever fewer words: the alphabets that contexts are made of.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "net/block_grid.hpp"

namespace g3d::net {

struct LevelClasses {
  std::array<std::uint8_t, kNoLevel + 1> steps{};  ///< 0..7 from saturation (32 or 0), 8: neither
  std::array<std::uint8_t, kNoLevel + 1> three{};  ///< 0 none, 1 unknown, 2 known
  std::array<std::uint8_t, kNoLevel + 1> sort{};   ///< 0 none or unknown, 1 free, 2 occupied
  std::array<std::uint8_t, kNoLevel + 1> four{};   ///< 0 none or unknown, 1 hardly free, 2 free, 3 occupied
  std::array<std::uint8_t, kNoLevel + 1> five{};   ///< 0 none, 1 unknown, 2 hardly free, 3 free, 4 occupied
  std::array<std::uint8_t, kNoLevel + 1>
      surface{};  ///< 0 none or unknown, 1 hardly free, 2 free, 3 hardly occ., 4 occ.
};
constexpr LevelClasses make_level_classes() {
  LevelClasses c;
  for (std::size_t level = 0; level <= kNoLevel; ++level) {
    const bool none = level > mapper::kMaxLevel;
    const bool is_free = level < mapper::kUnknownLevel;
    const bool is_occupied = level > mapper::kUnknownLevel && !none;
    const std::size_t steps = is_free ? level / 2 : is_occupied ? (mapper::kMaxLevel - level) / 2 : 8;
    const bool hardly = steps >= 5;
    c.steps[level] = static_cast<std::uint8_t>(steps);
    c.three[level] = static_cast<std::uint8_t>(none ? 0 : is_free || is_occupied ? 2 : 1);
    c.sort[level] = static_cast<std::uint8_t>(is_free ? 1 : is_occupied ? 2 : 0);
    c.four[level] = static_cast<std::uint8_t>(is_free ? (hardly ? 1 : 2) : is_occupied ? 3 : 0);
    c.five[level] = static_cast<std::uint8_t>(none ? 0 : 1 + c.four[level]);
    c.surface[level] = static_cast<std::uint8_t>(is_free ? (hardly ? 1 : 2) : is_occupied ? (hardly ? 3 : 4) : 0);
  }
  return c;
}
inline constexpr LevelClasses kLevelClasses = make_level_classes();

/// Where three numbers 0..8 stand among all such triples, whatever their order: 0..164.
struct TripleRanks {
  std::array<std::uint8_t, 729> rank{};
};
constexpr TripleRanks make_triple_ranks() {
  TripleRanks t;
  std::uint8_t next = 0;
  for (std::size_t a = 0; a < 9; ++a) {
    for (std::size_t b = a; b < 9; ++b) {
      for (std::size_t c = b; c < 9; ++c, ++next) {
        for (const auto& p : {std::array{a, b, c}, std::array{a, c, b}, std::array{b, a, c}, std::array{b, c, a},
                              std::array{c, a, b}, std::array{c, b, a}}) {
          t.rank[p[0] * 81 + p[1] * 9 + p[2]] = next;
        }
      }
    }
  }
  return t;
}
inline constexpr TripleRanks kTripleRanks = make_triple_ranks();

}  // namespace g3d::net
