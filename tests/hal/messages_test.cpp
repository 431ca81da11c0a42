// SPDX-License-Identifier: Apache-2.0
#include "hal/messages.hpp"

#include <catch2/catch.hpp>
#include <set>
#include <string>

using namespace g3d::hal;

TEST_CASE("Every drop reason has a name of its own") {
  std::set<std::string> names;
  for (std::size_t i = 0; i < kDropReasonCount; ++i) names.insert(to_string(static_cast<DropReason>(i)));
  CHECK(names.size() == kDropReasonCount);
  CHECK(names.count("unknown") == 0);
  CHECK(names.count("time_backwards") == 1);
}
