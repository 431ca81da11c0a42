// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/map_start.hpp"

#include <catch2/catch.hpp>

using namespace g3d::hal;

namespace {

struct Plan {
  Plan() : solid(60 * 40, 0), is_free(60 * 40, 0) {}
  void room(int x0, int y0, int x1, int y1) {
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const bool edge = x == x0 || y == y0 || x == x1 || y == y1;
        (edge ? solid : is_free)[static_cast<std::size_t>(y * 60 + x)] = 1;
      }
    }
  }
  [[nodiscard]] std::optional<PlanarPose> start() const {
    return widest_start(GridWalls(60, 40, 0.1F, {-1.0F, 2.0F}, 0.0F, 2.5F, solid), is_free);
  }
  std::vector<std::uint8_t> solid;
  std::vector<std::uint8_t> is_free;
};

}  // namespace

TEST_CASE("a robot starts in the middle of the widest room, not in what nobody has seen around it") {
  Plan plan;
  plan.room(2, 2, 14, 14);
  plan.room(20, 10, 40, 26);
  const auto start = plan.start();
  REQUIRE(start);
  CHECK(start->x_m == Approx(-1.0 + 3.05).margin(0.25));
  CHECK(start->y_m == Approx(2.0 + 1.85).margin(0.06));
}

TEST_CASE("a plan without room for a robot has no start") {
  Plan plan;
  plan.room(2, 2, 8, 20);
  CHECK_FALSE(plan.start());
  CHECK_FALSE(Plan().start());
}
