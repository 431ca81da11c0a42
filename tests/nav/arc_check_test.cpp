// SPDX-License-Identifier: Apache-2.0
#include "nav/arc_check.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "nav/motion_limits.hpp"

using namespace g3d;
using nav::Cell;
using nav::CellState;

namespace {

using Ground = nav::CellGrid<CellState>;
constexpr double kRadius_m = 0.18, kMargin_m = 0.01, kPi = 3.14159265358979323846;

Ground free_floor() { return {0.05, -2.0, -2.0, 80, 80, CellState::free}; }

nav::ArcCheck check_at(const Ground& ground, const hal::PlanarPose& pose) {
  nav::ArcCheck check(kRadius_m, kMargin_m, 0.6, ground.resolution_m);
  check.gather(ground, pose);
  return check;
}

}  // namespace

TEST_CASE("On an empty floor every arc is free to its end") {
  const auto check = check_at(free_floor(), {0.1, 0.2, 0.7});
  for (const double curvature : {-5.0, -1.0, 0.0, 0.5, 8.0}) {
    const nav::ArcView view = check.look(curvature, 0.5);
    CHECK(view.free_m >= 0.5);
    CHECK(view.clear_m >= 0.5);
    CHECK(view.clearance_m == nav::ArcCheck::kNoticed_m);
  }
}

TEST_CASE("A straight way ends before the body touches the near face of an occupied cell") {
  Ground ground = free_floor();
  ground.at(ground.cell_of(0.625, 0.025)) = CellState::occupied;  // covers 0.60..0.65
  const auto check = check_at(ground, {0.0, 0.025, 0.0});
  const nav::ArcView view = check.look(0.0, 0.6);
  CHECK(view.free_m <= 0.60 - kRadius_m - kMargin_m);
  CHECK(view.free_m > 0.60 - kRadius_m - kMargin_m - 2 * nav::ArcCheck::kStep_m);
  CHECK_FALSE(view.is_doubtful);
  CHECK(view.clear_m >= view.free_m);
  CHECK(view.clear_m <= 0.60 - kRadius_m - kMargin_m + nav::ArcCheck::kSlack_m + 0.01);
  CHECK(check.look(0.0, 0.6, true).clear_m >= 0.6);  // backwards there is nothing
  CHECK(check.look(-6.0, 0.35).clear_m >= 0.35);     // a tight turn passes it
  CHECK(check.clearance_m() == Approx(0.60 - kRadius_m));
}

TEST_CASE("Headings and sides are those of the world") {
  Ground ground = free_floor();
  ground.at(ground.cell_of(0.025, 0.475)) = CellState::occupied;
  CHECK(check_at(ground, {0.025, 0.0, 0.5 * kPi}).look(0.0, 0.6).clear_m < 0.3);
  CHECK(check_at(ground, {0.025, 0.0, -0.5 * kPi}).look(0.0, 0.6).clear_m >= 0.6);
  CHECK(check_at(ground, {0.025, 0.0, -0.5 * kPi}).look(0.0, 0.6, true).clear_m < 0.3);
  const auto sideways = check_at(ground, {-0.3, 0.15, 0.0});  // the cell is ahead on the left
  CHECK(sideways.look(2.5, 0.5).clear_m < 0.5);
  CHECK(sideways.look(-2.5, 0.5).clear_m >= 0.5);
}

TEST_CASE("Unknown cells end what is free, not what is clear") {
  Ground ground = free_floor();
  for (int y = 0; y < ground.rows; ++y) ground.at({50, y}) = CellState::unknown;  // x 0.50..0.55
  const nav::ArcView view = check_at(ground, {0.0, 0.0, 0.0}).look(0.0, 0.6);
  CHECK(view.free_m <= 0.525 - kRadius_m);
  CHECK(view.free_m > 0.525 - kRadius_m - 2 * nav::ArcCheck::kStep_m);
  CHECK(view.clear_m >= 0.6);
  CHECK(view.is_doubtful);
}

TEST_CASE("A floor that is only presumed is as good as unknown") {
  struct SeenUntil final : nav::FloorKnowledge {
    int column = 50;  // x 0.50..0.55
    [[nodiscard]] bool is_seen(Cell c) const override { return c.x < column; }
  } seen;
  const Ground ground = free_floor();
  nav::ArcCheck check(kRadius_m, kMargin_m, 0.6, ground.resolution_m);
  check.gather(ground, {0.0, 0.0, 0.0}, &seen);
  const nav::ArcView view = check.look(0.0, 0.6);
  CHECK(view.free_m <= 0.525 - kRadius_m);
  CHECK(view.free_m > 0.525 - kRadius_m - 2 * nav::ArcCheck::kStep_m);
  CHECK(view.is_doubtful);
  CHECK(view.clear_m >= 0.6);
  seen.column = 80;
  check.gather(ground, {0.0, 0.0, 0.0}, &seen);
  CHECK(check.look(0.0, 0.6).free_m >= 0.6);
}

TEST_CASE("Free floor that nobody watches ends what is watched, and nothing else") {
  struct WatchedUntil final : nav::FloorKnowledge {
    [[nodiscard]] bool is_seen(Cell) const override { return true; }
    [[nodiscard]] bool is_unwatched(Cell c) const override { return c.x >= 50; }  // from x 0.50
  } watched;
  const Ground ground = free_floor();
  nav::ArcCheck check(kRadius_m, kMargin_m, 0.6, ground.resolution_m);
  check.gather(ground, {0.0, 0.0, 0.0}, &watched);
  const nav::ArcView view = check.look(0.0, 0.6);
  CHECK(view.watched_m <= 0.525 - kRadius_m);
  CHECK(view.watched_m > 0.525 - kRadius_m - 2 * nav::ArcCheck::kStep_m);
  CHECK(view.free_m >= 0.6);
  CHECK(view.clear_m >= 0.6);
  CHECK_FALSE(view.is_doubtful);
  CHECK(check.look(0.0, 0.6, true).watched_m >= 0.6);
  check.gather(ground, {0.0, 0.0, 0.0});
  CHECK(check.look(0.0, 0.6).watched_m >= 0.6);
}

TEST_CASE("An occupied cell is a square, and where nothing else is left what the floor's knowledge says") {
  struct Knows final : nav::FloorKnowledge {
    [[nodiscard]] bool is_seen(Cell) const override { return true; }
    [[nodiscard]] nav::Extent extent(Cell) const override { return what; }
    nav::Extent what = nav::Extent::square;
  } knows;
  Ground ground = free_floor();
  // A gap of 35 cm between squares, of 40 cm between middles.
  ground.at(ground.cell_of(0.425, 0.22)) = ground.at(ground.cell_of(0.425, -0.18)) = CellState::occupied;
  const auto clear_m = [&](nav::Extent what, bool trusting) {
    knows.what = what;
    nav::ArcCheck check(kRadius_m, kMargin_m, 0.6, ground.resolution_m);
    check.gather(ground, {0.0, 0.025, 0.0}, &knows);
    return check.look(0.0, 0.6, false, trusting).clear_m;
  };
  CHECK(clear_m(nav::Extent::square, true) < 0.42);
  CHECK(clear_m(nav::Extent::middle, false) == clear_m(nav::Extent::square, true));
  CHECK(clear_m(nav::Extent::middle, true) >= 0.6);
  ground.at(ground.cell_of(0.425, 0.02)) = CellState::occupied;
  CHECK(clear_m(nav::Extent::middle, true) < 0.3);
  CHECK(clear_m(nav::Extent::nothing, false) < 0.3);
  CHECK(clear_m(nav::Extent::nothing, true) >= 0.6);
}

TEST_CASE("What lies outside of the grid is unknown") {
  const nav::ArcView view = check_at(free_floor(), {1.7, 0.0, 0.0}).look(0.0, 0.6);
  CHECK(view.free_m < 0.2);
  CHECK(view.clear_m >= 0.6);
}

TEST_CASE("A robot that stands in an obstacle's cell may leave it and not go deeper") {
  Ground ground = free_floor();
  for (int y = 0; y < ground.rows; ++y) ground.at({43, y}) = CellState::occupied;  // x 0.15..0.20
  const auto check = check_at(ground, {0.0, 0.0, 0.0});
  CHECK(check.clearance_m() < 0.0);
  CHECK(check.look(0.0, 0.4).clear_m == 0.0);
  CHECK(check.look(0.0, 0.4, true).clear_m >= 0.4);
  CHECK(check_at(ground, {0.0, 0.0, 0.5 * kPi}).look(0.0, 0.4).clear_m == 0.0);  // 3 cm deep: away, not along
  const auto along = check_at(ground, {-0.02, 0.0, 0.5 * kPi});                  // 1 cm: along or away
  CHECK(along.look(0.0, 0.4).clear_m >= 0.4);
  CHECK(along.look(1.0, 0.4).clear_m >= 0.4);
  CHECK(along.look(-1.0, 0.4).free_m < 0.05);
  CHECK(along.look(-1.0, 0.4).clear_m < 0.2);
}

TEST_CASE("A doorway of 0.60 m between grown cells lets the body through its middle") {
  Ground ground = free_floor();
  for (int y = 0; y < ground.rows; ++y) {
    const double centre_m = ground.centre_y_m({0, y});
    if (centre_m < -0.25 || centre_m > 0.25) ground.at({48, y}) = CellState::occupied;
  }
  CHECK(check_at(ground, {0.0, 0.0, 0.0}).look(0.0, 0.6).clear_m >= 0.6);
  CHECK(check_at(ground, {0.0, 0.10, 0.0}).look(0.0, 0.6).clear_m < 0.6);
  const nav::ArcView middle = check_at(ground, {0.0, 0.0, 0.0}).look(0.0, 0.6);
  CHECK(middle.clearance_m == Approx(0.25 - kRadius_m).margin(0.01));
}

TEST_CASE("Speeds that stop in time") {
  const nav::MotionLimits limits;
  for (const double d : {0.01, 0.05, 0.31, 1.0}) {
    const double v = nav::speed_to_stop_within(d, limits.deceleration_mps2, limits.reaction_s);
    CHECK(nav::distance_to_stop(v, limits.deceleration_mps2, limits.reaction_s) == Approx(d));
  }
  CHECK(nav::speed_to_stop_within(-0.1, 0.6, 0.2) == 0.0);
  CHECK(nav::turn_rate_to(3.0, limits) == limits.max_turn_radps);
  CHECK(nav::turn_rate_to(-3.0, limits) == -limits.max_turn_radps);
  CHECK(std::fabs(nav::turn_rate_to(0.05, limits)) < 0.6);
  CHECK(nav::wrap_angle(3.5) == Approx(3.5 - 2 * kPi));
}
