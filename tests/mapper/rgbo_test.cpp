// SPDX-License-Identifier: Apache-2.0
#include "mapper/rgbo.hpp"

#include <catch2/catch.hpp>
#include <vector>

using namespace g3d::mapper;

namespace {

std::vector<UpdateSteps> all_steps() {
  std::vector<UpdateSteps> all;
  for (std::uint8_t hit = 1; hit <= 16; ++hit) {
    for (std::uint8_t miss = 1; miss <= 16; ++miss) all.push_back({hit, miss});
  }
  return all;
}

}  // namespace

TEST_CASE("a code holds red, green, blue and the level, from high byte to low") {
  constexpr Rgbo code = make_rgbo(1, 2, 3, 32);
  CHECK(code == 0x01020320U);
  CHECK(level_of(code) == 32);
  CHECK(level_of(code | kHasColourBit) == 32);
  CHECK(state_of(make_rgbo(255, 255, 255, 15)) == State::free);
  CHECK(state_of(kUnknownRgbo) == State::unknown);
  CHECK(state_of(17) == State::occupied);
}

TEST_CASE("levels 0..15 are free, 16 is unknown, 17..32 are occupied") {
  for (std::uint8_t level = 0; level <= kMaxLevel; ++level) {
    CHECK(state_of_level(level) == (level < 16 ? State::free : level == 16 ? State::unknown : State::occupied));
  }
}

TEST_CASE("no update ever rests on unknown, leaves 0..32 or moves the wrong way") {
  for (const UpdateSteps steps : all_steps()) {
    for (std::uint8_t level = 0; level <= kMaxLevel; ++level) {
      const std::uint8_t hit = after_hit(level, steps);
      const std::uint8_t miss = after_miss(level, steps);
      REQUIRE(hit != kUnknownLevel);
      REQUIRE(miss != kUnknownLevel);
      REQUIRE(hit <= kMaxLevel);
      REQUIRE(hit >= level);
      REQUIRE(miss <= level);
      const int raised = level + steps.hit;
      const int lowered = level - steps.miss;
      if (raised != 16) REQUIRE(hit == (raised > 32 ? 32 : raised));
      if (raised == 16) REQUIRE(hit == 17);
      if (lowered != 16) REQUIRE(miss == (lowered < 0 ? 0 : lowered));
      if (lowered == 16) REQUIRE(miss == 15);
    }
  }
}

TEST_CASE("with the default steps one hit makes occupied, one miss makes free") {
  CHECK(after_hit(kUnknownLevel, {}) == 20);
  CHECK(after_miss(kUnknownLevel, {}) == 14);
  CHECK(after_hit(12, {}) == 17);
  CHECK(after_miss(18, {}) == 15);
  CHECK(after_hit(31, {}) == 32);
  CHECK(after_miss(1, {}) == 0);
}

TEST_CASE("a voxel seen full for long is free again within half a second at 30 Hz") {
  std::uint8_t level = kUnknownLevel;
  for (int frame = 0; frame < 1000; ++frame) level = after_hit(level, {});
  CHECK(level == kMaxLevel);
  int frames = 0;
  while (state_of_level(level) != State::free) {
    level = after_miss(level, {});
    ++frames;
  }
  CHECK(frames <= 15);
  CHECK(frames == 8);  // 32 -> 16 in steps of 2, and the last of them does not rest there
}

TEST_CASE("hits outweigh misses one to two, so that a flickering surface stays") {
  std::uint8_t level = after_hit(kUnknownLevel, {});
  for (int frame = 0; frame < 100; ++frame) {
    level = frame % 3 == 0 ? after_hit(level, {}) : after_miss(level, {});
    if (frame > 3) REQUIRE(level >= 13);
  }
  std::uint8_t even = kMaxLevel;
  for (int frame = 0; frame < 1000; ++frame) even = frame % 2 == 0 ? after_miss(even, {}) : after_hit(even, {});
  CHECK(state_of_level(even) == State::occupied);
}

TEST_CASE("the average of two colours rounds up, keeps constants and never darkens a white wall") {
  for (int a = 0; a < 256; ++a) {
    for (int b = 0; b < 256; ++b) {
      const int mean = blend_channel(static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b));
      REQUIRE(2 * mean - a - b >= 0);
      REQUIRE(2 * mean - a - b <= 1);
      const auto all = static_cast<std::uint32_t>(mean << 16 | mean << 8 | mean);
      REQUIRE(blend_rgb(0x010101U * static_cast<std::uint32_t>(a), 0x010101U * static_cast<std::uint32_t>(b)) == all);
    }
    REQUIRE(blend_channel(static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(a)) == a);
  }
  CHECK(blend_rgb(0x00FF10U, 0xFF0021U) == 0x808019U);
}
