// SPDX-License-Identifier: Apache-2.0
// Where the coding of every block starts: which model stands where in one array, and what maps taught it beforehand.
//
// A block is too short to teach a model much, so nearly all knowledge is here: per context the logit of a set bit, in
// quarters, as one character. How it was obtained stands in trained_text.hpp. The table is part of the format: with
// another one, nothing that was sent before can be read.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "net/bit_model.hpp"

namespace g3d::net {

/// Contexts of one kind, one after the other; see block_levels.hpp and block_colours.hpp for what they are.
struct ModelGroup {
  std::size_t begin;
  std::size_t size;
  std::uint8_t trust;  ///< as how many bits seen in this block the table counts
  std::uint8_t most;   ///< BitModel::most
  [[nodiscard]] constexpr std::size_t end() const { return begin + size; }
};

inline constexpr std::size_t kStepNodes = 7;   ///< of a tree of three bits
inline constexpr std::size_t kMixedNodes = 9;  ///< of a colour's difference: zero or not, sign, seven of its width

inline constexpr ModelGroup kSameGroup{0, 33 * 7 * 2, 8, 255};
inline constexpr ModelGroup kKnownFaces{kSameGroup.end(), 27 * 32, 4, 255};
inline constexpr ModelGroup kKnownStrength{kKnownFaces.end(), 125 * 16, 4, 255};
inline constexpr ModelGroup kKnownCorners{kKnownStrength.end(), 27 * 16, 4, 255};
inline constexpr ModelGroup kSortFaces{kKnownCorners.end(), 27 * 16, 4, 255};
inline constexpr ModelGroup kSortStrength{kSortFaces.end(), 125, 4, 255};
inline constexpr ModelGroup kSortCorners{kSortStrength.end(), 729, 4, 255};
inline constexpr ModelGroup kStepRanks{kSortCorners.end(), 2 * 165 * kStepNodes, 3, 255};
inline constexpr ModelGroup kStepBelow{kStepRanks.end(), 2 * 144 * kStepNodes, 3, 255};
inline constexpr ModelGroup kStepPattern{kStepBelow.end(), 2 * 360 * kStepNodes, 3, 255};
inline constexpr ModelGroup kOddGroup{kStepPattern.end(), 2 * 8 * 8, 5, 255};
inline constexpr ModelGroup kFlagGroup{kOddGroup.end(), 3, 3, 60};
inline constexpr ModelGroup kColourGroup{kFlagGroup.end(), 3 * 3 * 16 * kMixedNodes, 8, 20};
inline constexpr ModelGroup kTopGroup{kColourGroup.end(), 3 * 7 * 4, 8, 20};
inline constexpr std::array<ModelGroup, 14> kModelGroups{
    kSameGroup, kKnownFaces, kKnownStrength, kKnownCorners, kSortFaces, kSortStrength, kSortCorners,
    kStepRanks, kStepBelow,  kStepPattern,   kOddGroup,     kFlagGroup, kColourGroup,  kTopGroup};
inline constexpr std::size_t kModelCount = kTopGroup.end();

/// Sets of weights: 8 for known, 3 for sort, 2 x 7 for steps, 3 x 9 for colours.
inline constexpr std::size_t kKnownMixes = 0;
inline constexpr std::size_t kSortMixes = 8;
inline constexpr std::size_t kStepMixes = kSortMixes + 3;
inline constexpr std::size_t kColourMixes = kStepMixes + 2 * kStepNodes;
inline constexpr std::size_t kMixCount = kColourMixes + 3 * kMixedNodes;

using StartModels = std::array<BitModel, kModelCount>;
using StartWeights = std::array<MixWeights, kMixCount>;

/// Characters: ' ' for a context that no map had, else '#'..'~' without '?' and '\' for -45..44.
inline constexpr int kHighestDigit = 89;
inline constexpr int kMiddleDigit = 45;
[[nodiscard]] constexpr int digit_of(char c) { return c - '#' - (c > '?' ? 1 : 0) - (c > '\\' ? 1 : 0); }
[[nodiscard]] constexpr char char_of(int digit) {
  const int c = '#' + digit + ('#' + digit >= '?' ? 1 : 0);
  return static_cast<char>(c + (c >= '\\' ? 1 : 0));
}
[[nodiscard]] StartModels read_models(std::string_view text);
[[nodiscard]] StartWeights read_weights(std::string_view text);  ///< digits are in 32nds

/// The trained ones (trained_text.hpp), made at the first call. Any thread.
[[nodiscard]] const StartModels& trained_models();
[[nodiscard]] const StartWeights& trained_weights();

}  // namespace g3d::net
