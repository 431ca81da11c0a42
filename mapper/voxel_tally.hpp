// SPDX-License-Identifier: Apache-2.0
// What several maps say of one voxel, summed before anything is clamped: level = clamp(16 + sum(O_i - 16)) over those
// that know it, colour from the surest one. So the result does not depend on who was asked first.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

struct VoxelTally {
  std::int32_t sum = 0;  ///< of O_i - 16
  Rgbo colour = 0;       ///< stored code of the surest coloured source, 0 = none
  std::uint64_t colour_layer = 0;

  /// `code`: with kHasColourBit. `layer`: of equally sure ones the lowest gives the colour, then the lowest RGB.
  void add(Rgbo code, std::uint64_t layer) {
    sum += static_cast<std::int32_t>(level_of(code)) - kUnknownLevel;
    if ((code & kHasColourBit) == 0 || state_of(code) != State::occupied) return;
    const bool wins = colour == 0 || level_of(code) > level_of(colour) ||
                      (level_of(code) == level_of(colour) &&
                       (layer < colour_layer || (layer == colour_layer && code >> 8 < colour >> 8)));
    if (!wins) return;
    colour = code;
    colour_layer = layer;
  }
  [[nodiscard]] Rgbo result() const {
    const auto level = static_cast<Rgbo>(std::clamp(kUnknownLevel + sum, 0, static_cast<std::int32_t>(kMaxLevel)));
    return level > kUnknownLevel && colour != 0 ? (colour & 0xFFFFFF00U) | kHasColourBit | level : level;
  }
};

using BlockTally = std::array<VoxelTally, kBlockVoxels>;

inline void add_block(BlockTally& tallies, const BlockValues& values, std::uint64_t layer) {
  for (std::size_t i = 0; i < values.size(); ++i) tallies[i].add(values[i], layer);
}
/// False if nothing is known.
inline bool take_result(const BlockTally& tallies, BlockValues& values) {
  bool known = false;
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = tallies[i].result();
    known = known || values[i] != kUnknownRgbo;
  }
  return known;
}

}  // namespace g3d::mapper
