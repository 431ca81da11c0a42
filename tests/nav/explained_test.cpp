// SPDX-License-Identifier: Apache-2.0
#include "nav/explained.hpp"

#include <catch2/catch.hpp>
#include <set>
#include <string>

using namespace g3d::nav;

TEST_CASE("every reason has a name of its own") {
  std::set<std::string> names;
  for (std::size_t i = 0; i < kLeftReasons; ++i) names.insert(std::string(name_of(static_cast<LeftReason>(i))));
  CHECK(names.size() == kLeftReasons);
  CHECK(name_of(LeftReason::too_small) == "too_small");
  CHECK(name_of(LeftReason::energy) == "energy");
}

TEST_CASE("frontiers left are counted by reason") {
  FrontiersLeft left;
  ++left[LeftReason::blocked];
  CHECK(left.clusters[static_cast<std::size_t>(LeftReason::blocked)] == 1);
  CHECK(left[LeftReason::too_small] == 0);
}
