// SPDX-License-Identifier: Apache-2.0
#include "nav/robot.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hal/frame_pool.hpp"
#include "hal/sim/sim_building.hpp"
#include "hal/sim/world_file.hpp"
#include "mapper/map_hash.hpp"
#include "tests/support/fake_card.hpp"

using namespace g3d;

namespace {

constexpr hal::TimeNs kLine_ns = 20'000'000;
constexpr int kLinesPerFrame = 5;  // 10 Hz

const std::string kRoom = "room 0 0 0  5 3.6 2.5 0.1\nbox 1.2 1.2 0  0.5 0.5 1\nstart -1.5 -0.6 20\n";
// A pane of glass all across the room: only the bumper finds it.
const std::string kPane = "room 0 0 0  10 2 2.5 0.1\nbox -2 0 0  0.02 2 2 glass\nstart -3.6 0 0\n";

/// A simulated building and the robot in it, in lockstep.
struct Run {
  explicit Run(const std::string& text, std::uint64_t seed = 1, mapper::Backend backend = mapper::Backend::cpu) {
    config.mapper.backend = backend;
    config.mapper.card_patience_ns = 20'000'000'000;  // the card in these tests is slow
    hal::World world = hal::parse_world(text, "w").value();
    config.T_world_start = world.starts().at(0);
    hal::SimBuildingOptions options;
    options.camera = hal::scaled_kinect(160, 120);
    options.seed = seed;
    hal::SimRobotOptions robot_options;
    robot_options.T_world_base = config.T_world_start;
    robot_options.base.seed = seed;
    options.robots = {robot_options};
    config.camera = options.camera;
    config.T_base_camera = robot_options.T_base_camera;
    building = std::make_unique<hal::SimBuilding>(std::move(world), options);
    robot = std::make_unique<nav::Robot>(config, clock);
    frame = hal::make_frame(config.camera);
  }

  void step() {
    building->advance_to(now);
    robot->on_line(building->line(0), now);
    if (lines++ % kLinesPerFrame == 0) {
      building->render(0, frame);
      frame.stamp_ns = now;
      robot->on_frame(frame, now);
      if (robot->last_frame_pose()) way.push_back(*robot->last_frame_pose());
    }
    now += kLine_ns;
  }
  void run(double duration_s) {
    const hal::TimeNs until = now + static_cast<hal::TimeNs>(duration_s * 1e9);
    while (now < until) step();
  }
  [[nodiscard]] std::uint64_t dropped(hal::DropReason reason) const {
    return robot->frames().dropped[static_cast<std::size_t>(reason)];
  }
  [[nodiscard]] bool is_balanced() const {
    std::uint64_t sum = robot->frames().integrated;
    for (const std::uint64_t count : robot->frames().dropped) sum += count;
    return sum == robot->frames().delivered;
  }

  hal::RealClock clock;
  nav::RobotConfig config;
  std::unique_ptr<hal::SimBuilding> building;
  std::unique_ptr<nav::Robot> robot;
  hal::Frame frame;
  hal::TimeNs now = 0;
  int lines = 0;
  std::vector<hal::Pose> way;
};

}  // namespace

TEST_CASE("a robot in lockstep drives, maps, and knows where it is", "[nav][robot][slow]") {
  Run run(kRoom);
  run.run(20.0);
  const nav::Robot& robot = *run.robot;
  CHECK(run.building->record(0).driven_m > 1.0);
  CHECK(run.building->record(0).contacts == 0);
  CHECK(robot.frames().delivered == 200);
  CHECK(robot.frames().integrated >= 199);  // the first frame may come before the first packet
  CHECK(run.is_balanced());
  CHECK(robot.mapper().map().counts().occupied > 1000);
  const hal::PlanarPose truth = run.building->T_world_base(0);
  CHECK(std::hypot(robot.T_world_base().x_m - truth.x_m, robot.T_world_base().y_m - truth.y_m) < 0.03);
  CHECK(std::abs(std::remainder(robot.T_world_base().heading_rad - truth.heading_rad, 6.283185307179586)) < 0.03);
  CHECK(robot.navigator().report().path_m == Approx(run.building->record(0).driven_m).margin(0.1));
}

TEST_CASE("a robot whose card reads the columns drives as one that looks at voxels", "[nav][robot][cuda]") {
  const test::FakeCard card(test::FakeDriver::works);
  Run plain(kRoom, 7);
  Run with_card(kRoom, 7, mapper::Backend::cuda);
  for (Run* run : {&plain, &with_card}) run->run(3.0);
  CHECK(with_card.robot->mapper().card().frames_on_card > 25);
  CHECK(plain.robot->navigator().ground().states().cells == with_card.robot->navigator().ground().states().cells);
  CHECK(plain.way.back().rotation_xyzw == with_card.way.back().rotation_xyzw);
  CHECK(plain.way.back().rotation_xyzw != plain.way.front().rotation_xyzw);  // it turns to look around
}

TEST_CASE("the same seed gives the same map and the same way, another seed another", "[nav][robot][slow]") {
  Run first(kRoom, 7);
  Run again(kRoom, 7);
  Run other(kRoom, 8);
  for (Run* run : {&first, &again, &other}) run->run(8.0);
  CHECK(mapper::map_hash(first.robot->mapper().map()) == mapper::map_hash(again.robot->mapper().map()));
  CHECK(mapper::map_hash(first.robot->mapper().map()) != mapper::map_hash(other.robot->mapper().map()));
  REQUIRE(first.way.size() == again.way.size());
  for (std::size_t i = 0; i < first.way.size(); ++i) {
    REQUIRE(first.way[i].translation_m == again.way[i].translation_m);
    REQUIRE(first.way[i].rotation_xyzw == again.way[i].rotation_xyzw);
  }
}

TEST_CASE("frames without a pose, out of order or of noise are counted, not mapped", "[nav][robot]") {
  Run run(kRoom);
  hal::Frame& frame = run.frame;
  run.building->render(0, frame);
  frame.stamp_ns = 0;
  run.robot->on_frame(frame, 0);  // no packet yet, so nobody knows where it was taken
  CHECK(run.dropped(hal::DropReason::no_pose) == 1);
  CHECK(run.robot->frames().integrated == 0);
  run.now = kLine_ns;
  run.run(3.0);
  const std::uint64_t integrated = run.robot->frames().integrated;
  CHECK(integrated > 25);
  const auto hash = mapper::map_hash(run.robot->mapper().map());

  frame.stamp_ns = run.now - 2'000'000'000;
  run.robot->on_frame(frame, run.now);
  CHECK(run.dropped(hal::DropReason::time_backwards) == 1);
  frame.stamp_ns = run.now - kLine_ns;
  std::uint32_t noise = 1;
  for (std::size_t i = 0; i < run.config.camera.pixel_count(); ++i) {
    noise = noise * 1664525U + 1013904223U;
    frame.depth[i] = static_cast<std::uint16_t>(500 + (noise >> 16) % 6000);
  }
  run.robot->on_frame(frame, run.now);
  CHECK(run.dropped(hal::DropReason::unreadable_depth) == 1);
  CHECK(run.robot->frames().integrated == integrated);
  CHECK(run.is_balanced());
  CHECK(mapper::map_hash(run.robot->mapper().map()) == hash);
}

TEST_CASE("without images the robot stands, and goes on when it sees again", "[nav][robot]") {
  Run run(kRoom);
  run.run(6.0);
  for (int i = 0; i < 100; ++i) {  // 2 s of the line alone: the camera is silent
    run.building->advance_to(run.now);
    run.robot->on_line(run.building->line(0), run.now);
    run.now += kLine_ns;
  }
  const hal::Twist velocity = run.building->body(0).velocity();
  CHECK(std::abs(velocity.forward_mps) < 0.005);
  const double driven_m = run.building->record(0).driven_m;
  run.run(8.0);  // it sees again, and goes on by itself
  CHECK(run.building->record(0).driven_m > driven_m + 0.2);
}

TEST_CASE("a contact stops the base at once, and what was touched is on the map", "[nav][robot]") {
  Run run(kPane);
  while (run.now < 60'000'000'000 && run.building->record(0).contacts == 0) run.step();
  REQUIRE(run.building->record(0).contacts == 1);
  const hal::ContactEvent& contact = run.building->record(0).events.at(0);
  CHECK(contact.at.x_m == Approx(-2.01).margin(0.01));
  CHECK(contact.bumper != 0);
  CHECK_FALSE(contact.measurable);
  run.run(0.1);
  CHECK(run.building->body(0).velocity().forward_mps <= 0.0);  // it stands, or already backs off
  CHECK(run.robot->base().began[static_cast<std::size_t>(hal::Condition::bumper)] == 1);
  run.run(1.0);
  const nav::GroundMap& ground = run.robot->navigator().ground();
  bool is_marked = false;
  for (double dy = -0.15; dy <= 0.15; dy += 0.05) {
    for (double x = -2.10; x <= -1.95; x += 0.05) {
      is_marked |= ground.is_contact(ground.states().cell_of(x, contact.at.y_m + dy));
    }
  }
  CHECK(is_marked);
}

TEST_CASE("a base that was unplugged is driven again when it is back", "[nav][robot]") {
  Run run(kRoom);
  run.run(2.0);
  const std::uint64_t packets = run.robot->base().packets;
  hal::KobukiFaults unplugged;
  unplugged.unplugged = true;
  run.building->kobuki(0).set_faults(unplugged);
  run.run(1.0);
  CHECK(run.robot->base().packets == packets);
  CHECK(run.robot->base().verdict.state == hal::SafetyState::stand);
  run.building->kobuki(0).set_faults({});
  run.run(6.0);
  CHECK(run.robot->base().packets > packets);
  CHECK(run.robot->base().verdict.state == hal::SafetyState::free);
}
