// SPDX-License-Identifier: Apache-2.0
// The compiled half of {fmt} is linked and formats what we use of it.
#include <fmt/format.h>

#include <catch2/catch.hpp>

TEST_CASE("fmt formats integers, floats and text", "[hal]") {
  CHECK(fmt::format("{:>4}|{:.3f}|{}", 7, 2.0 / 3.0, "x") == "   7|0.667|x");
  CHECK(fmt::format("{}", 0.1F) == "0.1");  // shortest text that reads back as the same float
  CHECK(fmt::format("{}", 1e300) == "1e+300");
  CHECK(fmt::format("{:#x}", 255U) == "0xff");
}
