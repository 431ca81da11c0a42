// SPDX-License-Identifier: Apache-2.0
// OctoMap's two file formats, as read and written by octomap 1.9 (AbstractOcTree.cpp, OcTreeBaseImpl.hxx,
// ColorOcTree.cpp, OccupancyOcTreeBase.hxx). Both are a text header and the octree in depth-first order:
//   .ot  per node: f32 log-odds, for ColorOcTree 3 bytes RGB (white = none), u8 mask of children
//   .bt  per inner node: u16, two bits per child: 00 unknown, 01 free, 10 occupied, 11 inner node
// Its child index has x as bit 0, y as 1, z as 2, and its key floor(x / r) + 32768 names the same cell as our integer
// k: so its depth-first order is ascending order of our M-codes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "mapper/morton.hpp"
#include "mapper/rgbo.hpp"

namespace g3d::mapper {

inline constexpr int kBlockDepth = kAxisBits - 3;  ///< depth of the node that is one of our blocks

/// One level in log-odds: a hit of +4 is OctoMap's default hit, log(0.7 / 0.3); 0..32 then span +-3.39 (p
/// 0.033..0.967).
inline constexpr float kLogOddsPerLevel = 0.8472979F / 4.0F;

[[nodiscard]] inline float log_odds_of(std::uint8_t level) {
  return static_cast<float>(static_cast<int>(level) - kUnknownLevel) * kLogOddsPerLevel;
}
/// Inverse of log_odds_of; other programs' values are rounded and clamped, and as in OctoMap 0 counts as occupied.
[[nodiscard]] inline std::uint8_t level_of_log_odds(float log_odds) {
  const float steps = std::clamp(std::round(log_odds / kLogOddsPerLevel), -16.0F, 16.0F);
  const int level = kUnknownLevel + static_cast<int>(steps);
  if (level != kUnknownLevel) return static_cast<std::uint8_t>(level);
  return log_odds < 0.0F ? kUnknownLevel - 1 : kUnknownLevel + 1;
}

}  // namespace g3d::mapper
