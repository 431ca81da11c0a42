// SPDX-License-Identifier: Apache-2.0
#include "nav/seconds.hpp"

#include <catch2/catch.hpp>

using namespace g3d::nav;

TEST_CASE("a span of seconds leads from one time to another and back", "[nav]") {
  CHECK(after(1'000, 2.5) == 2'500'001'000);
  CHECK(after(2'500'001'000, -2.5) == 1'000);
  CHECK(seconds_between(1'000, after(1'000, 0.125)) == Approx(0.125));
  CHECK(seconds_between(5, 5) == 0.0);
}
