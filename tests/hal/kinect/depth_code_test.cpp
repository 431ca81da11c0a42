// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <vector>

#include "hal/kinect/depth_code.hpp"
#include "tests/support/oni_builder.hpp"

using g3d::hal::kinect::is_whole_depth_code;
using Code = std::vector<std::uint8_t>;

TEST_CASE("a depth code is whole if it decodes to all pixels, not one fewer or more") {
  for (const std::size_t pixels : {1U, 2U, 3U, 61U, 62U, 640U * 480U}) {
    const Code code = g3d::test::flat_depth_code(pixels, 1234);
    INFO(pixels);
    CHECK(is_whole_depth_code(code, true, pixels));
    CHECK_FALSE(is_whole_depth_code(code, true, pixels + 1));
    CHECK_FALSE(is_whole_depth_code(code, true, pixels - 1));
    for (std::size_t cut = 0; cut < std::min<std::size_t>(code.size(), 20); ++cut) {
      CHECK_FALSE(is_whole_depth_code(std::span(code).first(cut), true, pixels));
    }
  }
}

TEST_CASE("each kind of step in a depth code") {
  // Without a table values stand for themselves: 1000, then +6, -7 in one byte; "one only"; larger steps; whole values.
  CHECK(is_whole_depth_code(Code{0xE8, 0x03, 0x0C}, false, 3));
  CHECK(is_whole_depth_code(Code{0xE8, 0x03, 0x6D}, false, 2));
  CHECK(is_whole_depth_code(Code{0xE8, 0x03, 0x6F, 0x90}, false, 3));
  CHECK(is_whole_depth_code(Code{0xE8, 0x03, 0x6F, 0x04, 0x00}, false, 3));
  CHECK(is_whole_depth_code(Code{0xE8, 0x03, 0xFF, 0x90}, false, 2));
  CHECK(is_whole_depth_code(Code{0xE8, 0x03, 0xFF, 0x04, 0x00}, false, 2));
  CHECK(is_whole_depth_code(Code{0xE8, 0x03, 0xE2}, false, 5));
  // Cut within a step.
  CHECK_FALSE(is_whole_depth_code(Code{0xE8, 0x03, 0x6F}, false, 3));
  CHECK_FALSE(is_whole_depth_code(Code{0xE8, 0x03, 0x6F, 0x04}, false, 3));
  CHECK_FALSE(is_whole_depth_code(Code{0xE8, 0x03, 0xFF}, false, 2));
  CHECK_FALSE(is_whole_depth_code(Code{}, false, 1));
  CHECK_FALSE(is_whole_depth_code(Code{0xE8, 0x03}, false, 0));
}

TEST_CASE("a value beyond its table is no whole code") {
  // A table of two, first value 1, then a step to 2.
  CHECK(is_whole_depth_code(Code{2, 0, 0, 0, 9, 0, 1, 0, 0x7D}, true, 2));
  CHECK_FALSE(is_whole_depth_code(Code{2, 0, 0, 0, 9, 0, 1, 0, 0x5D}, true, 2));
  CHECK_FALSE(is_whole_depth_code(Code{0, 0, 0, 0}, true, 1));
  CHECK_FALSE(is_whole_depth_code(Code{0xFF, 0xFF, 0, 0}, true, 1));
}
