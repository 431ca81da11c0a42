// SPDX-License-Identifier: Apache-2.0
#include "nav/trodden_way.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using namespace g3d::nav;

TEST_CASE("a way is kept in steps, each moves as its time says, and a long one gets coarser instead of ending") {
  TroddenWay way;
  way.tread({1, 0.0, 0.0});
  way.tread({2, 0.01, 0.0});
  way.tread({3, 0.05, 0.0});
  REQUIRE(way.places().size() == 2);
  CHECK(way.places()[1].at_ns == 3);
  way.move(mapper::submaps::ChainMove({0, 3}, {{}, hal::from_xyz_rpy(0, 1, 0, 0, 0, 0)}));
  CHECK(way.places()[0].y_m == 0.0);
  CHECK(way.places()[1].y_m == Approx(1.0));

  TroddenWay longer;
  const auto places = static_cast<int>(TroddenWay::kMost) + 10;
  for (int i = 0; i < places; ++i) longer.tread({i, 0.05 * i, 0.0});
  CHECK(longer.places().size() < TroddenWay::kMost);
  CHECK(longer.places().front().at_ns == 0);
  CHECK(longer.places().back().at_ns == places - 1);
  for (std::size_t i = 1; i < longer.places().size(); ++i) {
    CHECK(longer.places()[i].at_ns - longer.places()[i - 1].at_ns <= 2);
  }
}
