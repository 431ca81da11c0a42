// SPDX-License-Identifier: Apache-2.0
#include "nav/view_tour.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/support/flat_sim.hpp"

using namespace g3d;
using namespace g3d::nav;

namespace {

/// A hall of 20 x 3 m that is known but for its two ends; the robot stands nearer to the left one.
struct Hall {
  Hall() {
    world.solid = CellGrid<std::uint8_t>(0.05, 0.0, 0.0, 400, 60, 0);
    ground = CellGrid<CellState>(0.05, 0.0, 0.0, 400, 60, CellState::free);
    for (int y = 0; y < 60; ++y) {
      for (int x = 0; x < 400; ++x) {
        const bool wall = x == 0 || y == 0 || x == 399 || y == 59;
        world.solid.at({x, y}) = wall;
        if (wall) ground.at({x, y}) = CellState::occupied;
        if (x < 40 || x > 370) ground.at({x, y}) = CellState::unknown;
      }
    }
    cost = tests::true_costs(world.solid);
    frontiers.reset(ground);
    roads.reset(cost, 0.18);
    roads.size_field(field);
    places.reset(ground, roads);
    targets.reset(ground.columns, ground.rows);
    ignored.assign(targets.size(), 0);
    tour.reset(roads, targets, TourConfig{}, camera.window());
    roads.travel(roads.road_of(ground.cell_of(robot.x_m, robot.y_m)), TravelField::kNever - 100, field);
    places.refresh(ground, cost, roads, field, frontiers, camera, 100000);
  }
  std::span<const View> plan() {
    return plan_where([](const Place&) { return true; });
  }
  std::span<const View> plan_where(const std::function<bool(const Place&)>& allowed) {
    return tour.plan({places, roads, field, robot, targets, ignored, allowed});
  }
  [[nodiscard]] double x_of(const View& view) const { return ground.centre_x_m(places.place(view.slot).cell); }

  tests::FlatWorld world;
  CellGrid<CellState> ground;
  CellGrid<std::uint8_t> cost;
  hal::PlanarPose robot{8.0, 1.5, 0.0};
  ViewGain camera{ViewModel{}, 0.05};
  FrontierMap frontiers;
  RoadGrid roads;
  TravelField field;
  Viewpoints places;
  Targets targets;
  std::vector<std::uint8_t> ignored;
  ViewTour tour;
};

}  // namespace

TEST_CASE("both ends are visited, the near one first, each faced from a distance that the camera can measure") {
  Hall hall;
  const auto views = hall.plan();
  REQUIRE(views.size() >= 2);
  CHECK(hall.x_of(views.front()) < 8.0);
  CHECK(hall.x_of(views.back()) > 12.0);
  CHECK(std::cos(views.front().heading_rad) < -0.7);
  CHECK(std::cos(views.back().heading_rad) > 0.7);
  for (const View& view : views) CHECK(view.gain_cells >= 6.0F);
}

TEST_CASE("what is ignored is not looked at") {
  Hall hall;
  for (const std::uint32_t cell : hall.frontiers.cells()) {
    if (hall.ground.cell(cell).x < 200) hall.ignored[hall.targets.of_cell(cell)] = 1;
  }
  for (const View& view : hall.plan()) CHECK(hall.x_of(view) > 12.0);
  hall.ignored.assign(hall.targets.size(), 1);
  CHECK(hall.plan().empty());
}

TEST_CASE("places that are not allowed are not gone to") {
  Hall hall;
  const auto views = hall.plan_where([](const Place& place) { return place.cell.x > 100; });
  REQUIRE_FALSE(views.empty());
  for (const View& view : views) CHECK(hall.places.place(view.slot).cell.x > 100);
}

TEST_CASE("a view that is driven to stays first while another is better by little") {
  Hall hall;
  hall.robot.x_m = 10.2;
  hall.roads.travel(hall.roads.road_of(hall.ground.cell_of(10.2, 1.5)), TravelField::kNever - 100, hall.field);
  const auto views = hall.plan();
  REQUIRE(views.size() >= 2);
  const View other = views.back();
  const View first = views.front();
  hall.tour.keep(first);
  CHECK(hall.plan().front().slot == first.slot);
  CHECK(hall.plan().front().first_bearing == first.first_bearing);
  REQUIRE(hall.x_of(other) != hall.x_of(first));
}

TEST_CASE("turning towards a view and away from the way there costs time") {
  Hall hall;
  const std::uint32_t here = hall.field.reached.front();
  const std::uint32_t there = hall.roads.road_of(hall.ground.cell_of(12.0, 1.5));
  const double straight = hall.tour.seconds_to(hall.roads, hall.field, hall.robot, here, there, 0.0);
  CHECK(straight == Approx(4.0 / 0.4).epsilon(0.1));
  const double turned = hall.tour.seconds_to(hall.roads, hall.field, hall.robot, here, there, 3.14159);
  CHECK(turned - straight == Approx(3.14159).epsilon(0.1));
  CHECK(hall.tour.seconds_to(hall.roads, hall.field, hall.robot, here, here, -1.5) == Approx(1.5));
}

TEST_CASE("targets are squares of 4 x 4 cells") {
  Targets targets;
  targets.reset(10, 9);
  CHECK(targets.size() == 9);
  CHECK(targets.of_cell(0) == targets.of_cell(3 * 10 + 3));
  CHECK(targets.of_cell(4) == 1);
  CHECK(targets.of_cell(8 * 10 + 9) == 8);
}

TEST_CASE("a tour planned piece by piece is the one that is planned at once") {
  Hall hall;
  const auto at_once = hall.plan();
  const std::vector<View> whole(at_once.begin(), at_once.end());
  const std::function<bool(const Place&)> anywhere = [](const Place&) { return true; };
  int pieces = 1;
  hall.tour.begin();
  for (;; ++pieces) {
    WorkBudget budget(1);
    if (hall.tour.go_on({hall.places, hall.roads, hall.field, hall.robot, hall.targets, hall.ignored, anywhere},
                        budget)) {
      break;
    }
    REQUIRE(pieces < 10'000'000);
  }
  CHECK(pieces > 100);
  REQUIRE(hall.tour.views().size() == whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    CHECK(hall.tour.views()[i].slot == whole[i].slot);
    CHECK(hall.tour.views()[i].heading_rad == whole[i].heading_rad);
  }
}
