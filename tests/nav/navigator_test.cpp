// SPDX-License-Identifier: Apache-2.0
#include "nav/navigator.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "hal/kobuki/feedback.hpp"
#include "tests/support/voxel_floor.hpp"

using namespace g3d;
using nav::MissionState;
using tests::Box;

namespace {

constexpr double kStep_s = 0.02;
constexpr int kStepsPerFrame = 5;  // 10 Hz

nav::NavigatorConfig config_for(double side_m) {
  nav::NavigatorConfig config;
  config.ground.side_m = side_m;
  return config;
}

/// Walls around a rectangle.
std::vector<Box> room(const Box& inner) {
  constexpr double kThick_m = 0.15;
  return {{inner.x0_m - kThick_m, inner.y0_m - kThick_m, inner.x1_m + kThick_m, inner.y0_m},
          {inner.x0_m - kThick_m, inner.y1_m, inner.x1_m + kThick_m, inner.y1_m + kThick_m},
          {inner.x0_m - kThick_m, inner.y0_m, inner.x0_m, inner.y1_m},
          {inner.x1_m, inner.y0_m, inner.x1_m + kThick_m, inner.y1_m}};
}

struct World {
  tests::KinematicRobot robot;
  tests::VoxelFloor floor;
  nav::Navigator navigator;
  hal::TimeNs now = 0;
  int steps = 0;
  std::uint8_t bumper = 0;
  hal::Verdict verdict{hal::SafetyState::free, hal::free_allowance(), hal::Condition::count_};

  World(const std::vector<Box>& boxes, const hal::PlanarPose& start, const Box& extent,
        const nav::NavigatorConfig& config = config_for(25.6))
      : robot(boxes, start), floor(extent), navigator(floor.map().grid(), config) {}

  void step() {
    nav::BaseView view;
    view.T_world_base = robot.pose();
    view.velocity = robot.velocity();
    view.bumper = robot.is_touching() && robot.velocity().forward_mps >= 0.0 ? hal::kobuki::kBumperCentre : bumper;
    view.verdict = verdict;
    navigator.on_base(view, now);
    if (steps++ % kStepsPerFrame == 0) {
      floor.look(robot);
      navigator.on_map(floor.map(), floor.changed_slots(), {}, now);
    }
    robot.step(hal::permit(navigator.step(now), verdict.allowance), kStep_s);
    now += static_cast<hal::TimeNs>(kStep_s * 1e9);
  }
  void run(double duration_s) {
    const hal::TimeNs until = now + static_cast<hal::TimeNs>(duration_s * 1e9);
    while (now < until) step();
  }
  bool reaches(MissionState state, double limit_s) {
    const hal::TimeNs until = now + static_cast<hal::TimeNs>(limit_s * 1e9);
    while (now < until && navigator.mission().state() != state) step();
    return navigator.mission().state() == state;
  }
  [[nodiscard]] double time_s() const { return static_cast<double>(now) * 1e-9; }
};

/// Two rooms with a door 0.60 m wide between them, a cupboard in one and a table in the other.
std::vector<Box> two_rooms() {
  std::vector<Box> boxes = room({0, 0, 8, 4});
  boxes.push_back({3.9, 0, 4.03, 1.5});
  boxes.push_back({3.9, 2.1, 4.03, 4});
  boxes.push_back({0.0, 3.3, 1.0, 4.0});
  boxes.push_back({5.6, 1.0, 6.4, 1.6});
  return boxes;
}
constexpr Box kTwoRooms{-0.2, -0.2, 8.2, 4.2};

/// Goals in the order given, each once, then home.
class ListChooser final : public nav::GoalChooser {
 public:
  struct Told {
    int reached = 0;
    int failed = 0;
  };
  ListChooser(std::vector<hal::PlanarPose> goals, Told& told) : goals_(std::move(goals)), told_(told) {}
  void prepare(const nav::CellGrid<nav::CellState>&, const nav::CellGrid<std::uint8_t>&) override {}
  std::optional<nav::Decision> decide(const nav::CellGrid<nav::CellState>&, const nav::CellGrid<std::uint8_t>&,
                                      std::span<const std::uint32_t>, const hal::PlanarPose&, hal::TimeNs) override {
    if (++thinking_ % 10 != 0) return std::nullopt;
    nav::Decision d;
    if (next_ < goals_.size()) {
      d.kind = nav::DecisionKind::goal;
      d.goal = goals_[next_];
    } else if (next_ == goals_.size()) {
      d.kind = nav::DecisionKind::go_home;
      d.goal = home_;
    }
    return d;
  }
  void goal_reached() override { ++next_, ++told_.reached; }
  void goal_failed(nav::GoalFailure) override { ++next_, ++told_.failed; }
  void set_home(const hal::PlanarPose& home) override { home_ = home; }
  void set_energy_left(double) override {}
  void start_again() override {}
  void return_home(bool) override { next_ = goals_.size(); }
  [[nodiscard]] std::span<const std::uint32_t> frontier_cells() const override { return {}; }

 private:
  std::vector<hal::PlanarPose> goals_;
  Told& told_;
  std::size_t next_ = 0;
  int thinking_ = 0;  ///< it takes ten steps to decide
  hal::PlanarPose home_;
};

nav::CellGrid<nav::CellState> inside(const std::vector<Box>& boxes) {
  auto floor = tests::known_floor(boxes, {0, 0, 8, 4});
  return floor;
}

}  // namespace

TEST_CASE("It explores two rooms through a narrow door and returns home without touching anything", "[slow]") {
  World world(two_rooms(), {1.5, 1.5, 0.3}, kTwoRooms);
  CHECK(world.navigator.mission().state() == MissionState::starting);
  REQUIRE(world.reaches(MissionState::home, 300));
  CHECK(world.robot.contacts() == 0);
  CHECK(world.floor.coverage(inside(two_rooms())) > 0.985);
  CHECK(std::hypot(world.robot.pose().x_m - 1.5, world.robot.pose().y_m - 1.5) < 0.35);
  CHECK(world.navigator.report().path_m == Approx(world.robot.path_m()).epsilon(0.02));
  CHECK(world.navigator.report().goals_reached > 0);
  CHECK(world.navigator.decision().left.open == 0);
  CHECK(world.time_s() < 150);
}

TEST_CASE("It fits through a door that is 4 cm wider than itself, there and back, and not through one that is narrower",
          "[slow]") {
  for (const double width_m : {0.40, 0.35}) {
    std::vector<Box> boxes = room({0, 0, 8, 4});
    boxes.push_back({3.9, 0, 4.0, 1.6});
    boxes.push_back({3.9, 1.6 + width_m, 4.0, 4});
    World world(boxes, {1.5, 1.5, 0.3}, kTwoRooms);
    REQUIRE(world.reaches(MissionState::home, 400));
    CHECK(world.robot.contacts() == 0);
    const double seen = world.floor.coverage(inside(boxes));
    if (width_m == 0.40) {
      CHECK(seen > 0.98);
    } else {
      CHECK(seen < 0.9);
    }
  }
}

TEST_CASE("The same drive twice is the same drive", "[slow]") {
  World first(two_rooms(), {1.5, 1.5, 0.3}, kTwoRooms);
  World second(two_rooms(), {1.5, 1.5, 0.3}, kTwoRooms);
  first.run(40);
  second.run(40);
  CHECK(first.robot.pose() == second.robot.pose());
  CHECK(first.navigator.report().path_m == second.navigator.report().path_m);
  CHECK(first.navigator.report().paths_planned == second.navigator.report().paths_planned);
  CHECK(first.navigator.cost().cells == second.navigator.cost().cells);
}

TEST_CASE("What the camera cannot see is touched slowly or not at all, marked, and driven around", "[slow]") {
  World world(room({0, 0, 6, 3}), {0.8, 1.5, 0.0}, {-0.2, -0.2, 6.2, 3.2});
  world.robot.glass().push_back({2.6, 0.9, 2.7, 2.1});
  REQUIRE(world.reaches(MissionState::home, 400));
  CHECK(world.navigator.report().stops[0] > 0);
  CHECK(world.navigator.report().stops[0] < 12);
  CHECK(std::hypot(world.robot.pose().x_m - 0.8, world.robot.pose().y_m - 1.5) < 0.35);
}

TEST_CASE("Somebody who stands in the only way home for a while delays it and no more", "[slow]") {
  World world(two_rooms(), {1.5, 1.5, 0.3}, kTwoRooms);
  while (world.robot.pose().x_m < 5.2 && world.time_s() < 120) world.step();
  world.robot.boxes().push_back({3.85, 1.6, 4.1, 2.0});
  world.run(90);
  CHECK(world.robot.pose().x_m > 3.9);
  CHECK(world.navigator.mission().state() != MissionState::home);
  world.robot.boxes().pop_back();
  REQUIRE(world.reaches(MissionState::home, 300));
  CHECK(world.robot.contacts() == 0);
  CHECK(world.floor.coverage(inside(two_rooms())) > 0.98);
}

TEST_CASE("Cut off from where it came from it does not give up its goals, and goes on when the way is free", "[slow]") {
  World world(two_rooms(), {3.2, 1.8, 0.0}, kTwoRooms);
  while (world.robot.pose().x_m < 4.4 && world.time_s() < 120) world.step();
  world.robot.boxes().push_back({3.85, 1.55, 4.1, 2.05});
  const std::uint64_t failed_before = world.navigator.report().goals_failed;
  world.run(60);
  CHECK(world.navigator.report().goals_failed - failed_before < 30);
  world.robot.boxes().pop_back();
  REQUIRE(world.reaches(MissionState::home, 400));
  CHECK(world.robot.contacts() == 0);
  CHECK(world.floor.coverage(inside(two_rooms())) > 0.98);
}

TEST_CASE("Behind a door that proves narrower than planning likes it goes on exploring", "[slow]") {
  constexpr double kDoor_m = 0.6, kNarrow_m = 0.42, kMiddle_m = 2.0, kWall_m = 4.0, kBehind_m = 4.05;
  std::vector<Box> boxes = room({0, 0, 8, 4});
  boxes.push_back({kWall_m, 0, kBehind_m, kMiddle_m - kDoor_m / 2});
  boxes.push_back({kWall_m, kMiddle_m + kDoor_m / 2, kBehind_m, 4});
  boxes.push_back({1.6, 0, 1.75, 2.6});  // hides a third of the first room
  int explored_all = 0;
  for (const double start_x_m : {2.9, 3.0, 3.1, 3.2, 3.3}) {
    World world(boxes, {start_x_m, kMiddle_m, 0.0}, kTwoRooms);
    CAPTURE(start_x_m);
    while (world.robot.pose().x_m < 4.6 && world.time_s() < 120) world.step();
    REQUIRE(world.floor.coverage(inside(boxes)) < 0.9);  // there are goals to go back to
    world.robot.boxes().push_back({kWall_m, kMiddle_m - kDoor_m / 2, kBehind_m, kMiddle_m - kNarrow_m / 2});
    world.robot.boxes().push_back({kWall_m, kMiddle_m + kNarrow_m / 2, kBehind_m, kMiddle_m + kDoor_m / 2});
    REQUIRE(world.reaches(MissionState::home, 300));
    CHECK(world.robot.contacts() == 0);
    explored_all += world.floor.coverage(inside(boxes)) > 0.98 ? 1 : 0;
  }
  CHECK(explored_all >= 4);  // the follower has two centimetres to spare, and may give its goals up in the door
}

TEST_CASE("A person's word counts: pause, resume, stop, come home") {
  World world(two_rooms(), {1.5, 1.5, 0.3}, kTwoRooms);
  world.run(12);
  world.navigator.command(nav::MissionEvent::pause);
  world.run(1.5);
  const hal::PlanarPose paused = world.robot.pose();
  world.run(100);
  CHECK(world.robot.pose() == paused);
  CHECK(world.navigator.mission().state() == MissionState::paused);
  world.navigator.command(nav::MissionEvent::resume);
  world.run(3);
  CHECK_FALSE(world.robot.pose() == paused);
  CHECK(world.navigator.report().goals_failed == 0);     // the pause was not held against its goal
  world.navigator.command(nav::MissionEvent::explored);  // not a person's to say
  CHECK(world.navigator.mission().state() == MissionState::exploring);
  world.navigator.command(nav::MissionEvent::come_home);
  CHECK(world.navigator.mission().state() == MissionState::returning);
  REQUIRE(world.reaches(MissionState::home, 60));
  CHECK(world.floor.coverage(inside(two_rooms())) < 0.97);
  const hal::PlanarPose home = world.robot.pose();
  world.run(5);
  CHECK(std::hypot(world.robot.pose().x_m - home.x_m, world.robot.pose().y_m - home.y_m) < 0.2);
}

TEST_CASE("While the safety table forbids motion it waits, and goes on by itself afterwards") {
  World world(two_rooms(), {1.5, 1.5, 0.3}, kTwoRooms);
  world.run(20);
  hal::Conditions wrong;
  wrong.set(hal::Condition::silent_camera);
  world.verdict = hal::judge(wrong);
  world.run(30);
  CHECK(world.navigator.step(world.now) == hal::Twist{});
  world.verdict = hal::judge({});
  REQUIRE(world.reaches(MissionState::home, 300));
  CHECK(world.navigator.report().stops[static_cast<std::size_t>(nav::StopReason::safety)] == 1);
  CHECK(world.navigator.report().stops[static_cast<std::size_t>(nav::StopReason::no_progress)] == 0);
}

TEST_CASE("It gets away from where it starts, be it at a wall or in a corner", "[slow]") {
  for (const hal::PlanarPose start : {hal::PlanarPose{0.19, 1.5, 3.1}, hal::PlanarPose{0.19, 0.19, -2.4},
                                      hal::PlanarPose{3.70, 0.8, 0.0}, hal::PlanarPose{4.30, 3.80, 1.57}}) {
    World world(two_rooms(), start, kTwoRooms);
    CAPTURE(start.x_m, start.y_m);
    CHECK(world.reaches(MissionState::home, 400));
    CHECK(world.robot.contacts() == 0);
    CHECK(world.floor.coverage(inside(two_rooms())) > 0.98);
  }
}

TEST_CASE("Wheels that turn in vain end in a call for help, and a freed robot goes on", "[slow]") {
  World world(two_rooms(), {1.5, 1.5, 0.3}, kTwoRooms);
  world.run(15);
  world.robot.is_stuck = true;
  REQUIRE(world.reaches(MissionState::needs_help, 400));
  CHECK(world.navigator.report().stops[static_cast<std::size_t>(nav::StopReason::no_progress)] > 0);
  world.robot.is_stuck = false;
  REQUIRE(world.reaches(MissionState::home, 400));
}

TEST_CASE("Enclosed by touches that are none it forgets them instead of giving up the building", "[slow]") {
  World world(two_rooms(), {1.5, 1.5, 0.3}, kTwoRooms);
  world.run(3);
  // Pressed all around while it turns, by nothing: as a line with noise, or a lifted bumper, would say.
  for (int i = 0; i < 8 && world.navigator.mission().is_driving(); ++i) {
    world.bumper = hal::kobuki::kBumperLeft | hal::kobuki::kBumperRight | hal::kobuki::kBumperCentre;
    world.step();
    world.bumper = 0;
    world.run(1.2);
  }
  REQUIRE(world.reaches(MissionState::home, 600));
  std::size_t known = 0;
  for (const auto state : world.navigator.ground().states().cells) known += state != nav::CellState::unknown ? 1 : 0;
  CHECK(static_cast<double>(known) * 0.05 * 0.05 > 0.9 * 8 * 4);
}

TEST_CASE("Whoever else chooses the goals drives the same robot, is told what became of them, and is brought home") {
  ListChooser::Told told;
  nav::NavigatorConfig config = config_for(25.6);
  config.make_chooser = [&told](const nav::ExplorerConfig&) {
    return std::make_unique<ListChooser>(
        std::vector<hal::PlanarPose>{{3.0, 1.5, 1.57}, {-5.0, 1.5, 0.0}, {2.5, 2.5, -1.57}}, told);
  };
  World world(room({0, 0, 8, 4}), {1.5, 1.5, 0.3}, kTwoRooms, config);
  while (told.reached == 0 && world.time_s() < 60) world.step();
  CHECK(std::hypot(world.robot.pose().x_m - 3.0, world.robot.pose().y_m - 1.5) < 0.15);
  CHECK(world.robot.pose().heading_rad == Approx(1.57).margin(0.15));
  REQUIRE(world.reaches(MissionState::home, 120));
  CHECK(told.reached == 3);  // home is a goal as well
  CHECK(told.failed == 1);   // beyond the wall
  CHECK(world.robot.contacts() == 0);
}

TEST_CASE("While the map moves it stands, and it goes on where it is then", "[slow]") {
  World world(two_rooms(), {1.0, 1.0, 0.0}, kTwoRooms);
  world.run(25.0);
  REQUIRE(world.navigator.mission().state() == MissionState::exploring);
  world.navigator.on_map_moving(world.floor.map(), {});
  CHECK(world.navigator.step(world.now) == hal::Twist{});
  // Touched meanwhile, and still: it is told of it afterwards.
  nav::BaseView view;
  view.T_world_base = world.robot.pose();
  view.verdict = world.verdict;
  view.bumper = hal::kobuki::kBumperCentre;
  world.navigator.on_base(view, world.now);
  CHECK(world.navigator.step(world.now) == hal::Twist{});
  world.navigator.on_map_moving(world.floor.map(), world.floor.changed_slots());
  CHECK(world.navigator.step(world.now) == hal::Twist{});
  const std::uint64_t contacts = world.navigator.report().recoveries;
  const hal::PlanarPose home = world.navigator.home();
  world.navigator.on_map_moved(
      mapper::submaps::ChainMove({0, world.now - 1}, {{}, hal::from_xyz_rpy(0.0, 0.0, 0, 0, 0, 0)}), world.now);
  CHECK(world.navigator.home() == home);
  world.navigator.on_base(view, world.now);
  CHECK(world.navigator.report().recoveries == contacts + 1);
  CHECK(world.reaches(MissionState::home, 300.0));
  CHECK(world.floor.coverage(world.navigator.ground().states()) > 0.0);
}
