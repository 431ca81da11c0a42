// SPDX-License-Identifier: Apache-2.0
#include "nav/closed_way_check.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using nav::ClosedWayCheck;

namespace {

constexpr hal::TimeNs kSecond_ns = 1'000'000'000;

struct Scene {
  nav::CellGrid<std::uint8_t> cost{0.1, -10.0, -10.0, 200, 200, nav::kInscribedCost};
  ClosedWayCheck check{5.0};
  Scene() { check.note({5, 0}, {3, 0, 2.0}); }
};

}  // namespace

TEST_CASE("Nothing was found closed: there is nothing to look at") {
  Scene scene;
  ClosedWayCheck fresh(5.0);
  CHECK_FALSE(fresh.begin(scene.cost, {}));
  CHECK_FALSE(fresh.is_active());
}

TEST_CASE("A way that stays closed is watched for a while from where it was seen, a few times in all") {
  Scene scene;
  hal::TimeNs now = 0;
  for (int look = 0; look < nav::ClosedWays::kMostLooks; ++look) {
    const auto seen_from = scene.check.begin(scene.cost, {});
    REQUIRE(seen_from);
    CHECK(seen_from->x_m == 3);
    CHECK(seen_from->heading_rad == 0.0);
    CHECK(scene.check.is_active());
    now += 60 * kSecond_ns;  // on the way there
    CHECK_FALSE(scene.check.step(scene.cost, now));
    scene.check.watch(now);
    CHECK_FALSE(scene.check.step(scene.cost, now + 4 * kSecond_ns));
    CHECK(scene.check.step(scene.cost, now + 5 * kSecond_ns) == ClosedWayCheck::Finding::still_closed);
    CHECK_FALSE(scene.check.is_active());
  }
  CHECK_FALSE(scene.check.begin(scene.cost, {}));
}

TEST_CASE("A way that opens is found open at once, even from afar") {
  Scene scene;
  REQUIRE(scene.check.begin(scene.cost, {}));
  CHECK_FALSE(scene.check.step(scene.cost, 0));
  scene.cost.at(scene.cost.cell_of(5, 0)) = 40;
  CHECK(scene.check.step(scene.cost, kSecond_ns) == ClosedWayCheck::Finding::open_now);
  CHECK_FALSE(scene.check.is_active());
}

TEST_CASE("A check that is given up ends, and the next one begins with a drive again") {
  Scene scene;
  REQUIRE(scene.check.begin(scene.cost, {}));
  scene.check.watch(0);
  scene.check.end();
  CHECK_FALSE(scene.check.is_active());
  REQUIRE(scene.check.begin(scene.cost, {}));
  CHECK_FALSE(scene.check.step(scene.cost, 60 * kSecond_ns));
}
