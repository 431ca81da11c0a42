// SPDX-License-Identifier: Apache-2.0
// RGBO-codes and the update rules (thesis section 5.8, Algorithm 3, with its darkening average and its lost ties
// mended). RGBO = R<<24 | G<<16 | B<<8 | O. O is an occupancy level 0..32: 0..15 free, 16 unknown, 17..32 occupied.
#pragma once

#include <cstdint>

namespace g3d::mapper {

using Rgbo = std::uint32_t;

inline constexpr std::uint8_t kUnknownLevel = 16;
inline constexpr std::uint8_t kMaxLevel = 32;
inline constexpr std::uint8_t kLevelMask = 0x3F;     ///< low six bits of a stored byte: the level
inline constexpr std::uint8_t kHasColourBit = 0x40;  ///< stored byte only; never leaves the map
inline constexpr Rgbo kUnknownRgbo = kUnknownLevel;

enum class State : std::uint8_t { unknown, free, occupied };

[[nodiscard]] constexpr State state_of_level(std::uint8_t level) {
  return level < kUnknownLevel ? State::free : level > kUnknownLevel ? State::occupied : State::unknown;
}
[[nodiscard]] constexpr std::uint8_t level_of(Rgbo rgbo) { return static_cast<std::uint8_t>(rgbo & kLevelMask); }
[[nodiscard]] constexpr State state_of(Rgbo rgbo) { return state_of_level(level_of(rgbo)); }
[[nodiscard]] constexpr Rgbo make_rgbo(std::uint8_t r, std::uint8_t g, std::uint8_t b, std::uint8_t level) {
  return (static_cast<Rgbo>(r) << 24) | (static_cast<Rgbo>(g) << 16) | (static_cast<Rgbo>(b) << 8) | level;
}

/// What outsiders see of a stored code: spare bits zero, colour only on what is occupied.
[[nodiscard]] constexpr Rgbo published(Rgbo stored) {
  const Rgbo level = stored & kLevelMask;
  return level > kUnknownLevel && (stored & kHasColourBit) != 0 ? (stored & 0xFFFFFF00U) | level : level;
}

/// How strongly one frame moves a level.
struct UpdateSteps {
  std::uint8_t hit = 4;   ///< 1..16
  std::uint8_t miss = 2;  ///< 1..16
  bool operator==(const UpdateSteps&) const = default;
};

/// A level after a hit: never rests on 16, so that a seen voxel is never taken for an unseen one.
[[nodiscard]] constexpr std::uint8_t after_hit(std::uint8_t level, UpdateSteps steps) {
  const int raised = level + steps.hit;
  const int clamped = raised > kMaxLevel ? kMaxLevel : raised;
  return static_cast<std::uint8_t>(clamped == kUnknownLevel ? kUnknownLevel + 1 : clamped);
}

[[nodiscard]] constexpr std::uint8_t after_miss(std::uint8_t level, UpdateSteps steps) {
  const int lowered = level - steps.miss;
  const int clamped = lowered < 0 ? 0 : lowered;
  return static_cast<std::uint8_t>(clamped == kUnknownLevel ? kUnknownLevel - 1 : clamped);
}

/// One colour channel over frames: rounds up, so that a constant colour stays constant (the thesis's halves darken).
[[nodiscard]] constexpr std::uint8_t blend_channel(std::uint8_t old_value, std::uint8_t new_value) {
  return static_cast<std::uint8_t>((old_value + new_value + 1) >> 1);
}

/// blend_channel() of all three at once; R | G << 8 | B << 16, bits above zero. a + b = 2 (a | b) - (a ^ b).
[[nodiscard]] constexpr std::uint32_t blend_rgb(std::uint32_t old_rgb, std::uint32_t new_rgb) {
  return (old_rgb | new_rgb) - (((old_rgb ^ new_rgb) & 0xFEFEFEU) >> 1);
}

}  // namespace g3d::mapper
