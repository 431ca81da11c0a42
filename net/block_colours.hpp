// SPDX-License-Identifier: Apache-2.0
// Colours of a block through a coder that knows what to expect: for each occupied voxel whether it has one, and then G,
// R - G and B - G as differences from those of the coloured voxels around it that came before.
//
// A difference is told as: zero or not, its sign, how many bits it has, and these bits. What to expect depends on how
// much the colours around differ, and for R and B also on how wrong the guess of G was. Where nothing around is
// coloured, the last coloured voxel stands for it; before the first one it is grey.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "net/block_grid.hpp"
#include "net/block_models.hpp"

namespace g3d::net {

struct Tint {
  std::array<std::int16_t, 3> part{128, 0, 0};  ///< G, R - G, B - G
  bool known = false;
};
using TintGrid = std::array<Tint, kGridPlaces>;

[[nodiscard]] constexpr Tint tint_of(mapper::Rgbo value) {
  const int r = static_cast<int>(value >> 24);
  const int g = static_cast<int>(value >> 16 & 0xFFU);
  const int b = static_cast<int>(value >> 8 & 0xFFU);
  return {{static_cast<std::int16_t>(g), static_cast<std::int16_t>(r - g), static_cast<std::int16_t>(b - g)}, true};
}
[[nodiscard]] constexpr mapper::Rgbo rgb_of(const Tint& t) {
  return static_cast<mapper::Rgbo>(t.part[0] + t.part[1]) << 24 | static_cast<mapper::Rgbo>(t.part[0]) << 16 |
         static_cast<mapper::Rgbo>(t.part[0] + t.part[2]) << 8;
}

/// Faces, edges, corners.
inline constexpr std::array<int, 13> kTintsBefore{-1,
                                                  -kRow,
                                                  -kLayer,
                                                  -kRow - 1,
                                                  -kRow + 1,
                                                  -kLayer - 1,
                                                  -kLayer + 1,
                                                  -kLayer - kRow,
                                                  -kLayer + kRow,
                                                  -kLayer - kRow - 1,
                                                  -kLayer - kRow + 1,
                                                  -kLayer + kRow - 1,
                                                  -kLayer + kRow + 1};

template <typename Coder>
class ColourCoding {
 public:
  ColourCoding(Coder& coder, BlockModels& models) : coder_(coder), models_(models) {}

  /// The levels of `values` are known, when encoding all else is, too. `tints`: none is known, and so it is left.
  void run(mapper::BlockValues& values, TintGrid& tints, PlaceRange places) {
    Tint last;
    std::size_t last_flag = 2;
    for (std::size_t i = places.begin; i < places.end; ++i) {
      mapper::Rgbo& value = values[kGridOrder.block[i]];
      if (mapper::state_of(value) != mapper::State::occupied) continue;
      const bool coloured = coder_.code(models_.has_colour(last_flag), (value & mapper::kHasColourBit) != 0);
      last_flag = coloured ? 1 : 0;
      if (!coloured) continue;
      Tint& tint = tints[kGridOrder.grid[i]];
      tint = code(guess_from(&tint, last), tint_of(value), (mapper::kMaxLevel - mapper::level_of(value)) / 2U);
      last = tint;
      value = rgb_of(tint) | mapper::level_of(value) | mapper::kHasColourBit;
    }
    for (std::size_t i = places.begin; i < places.end; ++i) tints[kGridOrder.grid[i]].known = false;
  }

 private:
  struct Guess {
    std::array<int, 3> part{};
    std::array<std::size_t, 3> spread{};  ///< bits of the distance from the lowest to the highest, at most 6
    std::size_t count = 0;                ///< of coloured voxels around
    bool first = false;                   ///< no coloured voxel came before
  };

  static std::size_t bits_of(int value, std::size_t most) {
    return std::min(most, static_cast<std::size_t>(std::bit_width(static_cast<unsigned>(value))));
  }
  static int floor_div(int a, int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

  static Guess guess_from(const Tint* at, const Tint& last) {
    Guess guess;
    std::array<int, 3> sum{};
    std::array<int, 3> low{255, 255, 255};
    std::array<int, 3> high{-255, -255, -255};
    int weights = 0;
    for (std::size_t k = 0; k < kTintsBefore.size(); ++k) {
      const Tint& t = at[kTintsBefore[k]];
      if (!t.known) continue;
      const int weight = k < 3 ? 4 : k < 9 ? 2 : 1;
      weights += weight;
      ++guess.count;
      for (std::size_t c = 0; c < 3; ++c) {
        sum[c] += weight * t.part[c];
        low[c] = std::min<int>(low[c], t.part[c]);
        high[c] = std::max<int>(high[c], t.part[c]);
      }
    }
    guess.first = !last.known;
    for (std::size_t c = 0; c < 3; ++c) {
      guess.part[c] = weights == 0 ? last.part[c] : floor_div(2 * sum[c] + weights, 2 * weights);
      guess.spread[c] = weights == 0 ? 0 : bits_of(high[c] - low[c], 6);
    }
    return guess;
  }

  Tint code(const Guess& guess, const Tint& wanted, std::size_t level_steps) {
    Tint out;
    out.known = true;
    int off = 0;  // the worst miss among the parts so far
    for (std::size_t c = 0; c < 3; ++c) {
      const int base = c == 0 ? 0 : out.part[0];
      const int expected = std::clamp(base + guess.part[c], 0, 255);
      const int wrapped = ((base + wanted.part[c] - expected + 128) & 0xFF) - 128;
      const int difference = code_difference(c, contexts_of(guess, c, off, level_steps), wrapped);
      out.part[c] = static_cast<std::int16_t>(((expected + difference) & 0xFF) - base);
      off = std::max(off, std::abs(difference));
      recent_[c] += (std::abs(difference) * 16 - recent_[c]) / 4;
    }
    return out;
  }

  /// How the colours around differ, how wrong recent guesses were, and what else tells how sure this one is.
  std::array<std::size_t, kMixed> contexts_of(const Guess& guess, std::size_t c, int off,
                                              std::size_t level_steps) const {
    const std::size_t spread = guess.spread[c];
    const std::size_t recent = bits_of(recent_[c] >> 2, 7);
    if (c == 0) {
      const std::size_t around = guess.count == 0   ? (guess.first ? 0 : 1)
                                 : guess.count == 1 ? 2
                                                    : 3 + spread + (guess.count > 4 && spread > 3 ? 4 : 0);
      return {around, recent + (guess.count > 2 ? 8 : 0), level_steps * 2 + (guess.count > 1 ? 1 : 0)};
    }
    const std::size_t around = guess.count == 0 ? (guess.first ? 0 : 1) : guess.count == 1 ? 1 : spread < 2 ? 2 : 3;
    return {bits_of(off, 4) * 3 / 4 * 4 + around, recent + (spread >= 3 ? 8 : 0),
            bits_of(off, 7) + (level_steps > 3 ? 8 : 0)};
  }

  /// -128..127
  int code_difference(std::size_t channel, const std::array<std::size_t, kMixed>& contexts, int difference) {
    const auto code = [&](std::size_t node, bool bit) {
      return coder_.code(models_.colour(channel, contexts, node), bit);
    };
    if (code(0, difference == 0)) return 0;
    const bool negative = code(1, difference < 0);
    const auto size = static_cast<std::uint32_t>(std::abs(difference));
    std::uint32_t width = 1;
    while (width < 8 && code(1 + width, static_cast<std::uint32_t>(std::bit_width(size)) > width)) ++width;
    std::uint32_t value = 1;
    const auto code_top = [&](std::uint32_t depth) {
      const bool bit = coder_.code(models_.colour_top(channel, width, value), (size >> (width - depth) & 1U) != 0);
      value = value << 1 | (bit ? 1U : 0U);
    };
    if (width > 1) code_top(2);
    if (width > 2) {
      code_top(3);
      const int rest = static_cast<int>(width) - 3;  // noise
      value = value << rest | coder_.code_plain(size & ((1U << rest) - 1), rest);
    }
    return negative ? -static_cast<int>(value) : static_cast<int>(value);
  }

  std::array<int, 3> recent_{64, 32, 32};  ///< mean size of the last differences, in 16ths
  Coder& coder_;
  BlockModels& models_;
};

}  // namespace g3d::net
