// SPDX-License-Identifier: Apache-2.0
#include "mapper/version.hpp"

#include <catch2/catch.hpp>
#include <string>

TEST_CASE("the version is one printable word", "[mapper]") {
  const std::string version = g3d::mapper::version();
  REQUIRE_FALSE(version.empty());
  CHECK(version.find_first_of(" \t\n\"'") == std::string::npos);
}
