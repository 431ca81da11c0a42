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

/// The same for the 512 voxels of a block, to the bit. Sums are kept apart from colours, which few blocks have.
class BlockTally {
 public:
  void clear() {
    sums_.fill(0);
    has_colours_ = false;
  }
  /// Stored codes, as VoxelTally::add().
  void add(const BlockValues& values, std::uint64_t layer) {
    Rgbo all = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      sums_[i] += static_cast<std::int32_t>(values[i] & kLevelMask) - kUnknownLevel;
      all |= values[i];
    }
    if ((all & kHasColourBit) == 0) return;
    if (!has_colours_) colours_.fill({});
    has_colours_ = true;
    for (std::size_t i = 0; i < values.size(); ++i) colours_[i].add(values[i], layer);
  }
  /// False if nothing is known.
  bool take_result(BlockValues& values) const {
    Rgbo differs = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::int32_t level = kUnknownLevel + sums_[i];
      values[i] = static_cast<Rgbo>(std::clamp(level, 0, static_cast<std::int32_t>(kMaxLevel)));
      differs |= values[i] ^ kUnknownRgbo;
    }
    if (!has_colours_) return differs != 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const Rgbo colour = colours_[i].colour;
      if (colour != 0 && values[i] > kUnknownLevel) values[i] |= (colour & 0xFFFFFF00U) | kHasColourBit;
    }
    return differs != 0;
  }

 private:
  std::array<std::int32_t, kBlockVoxels> sums_{};   ///< of O_i - 16
  std::array<VoxelTally, kBlockVoxels> colours_{};  ///< valid if there are any; their sums do not count
  bool has_colours_ = false;
};

}  // namespace g3d::mapper
