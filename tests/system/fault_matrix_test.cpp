// SPDX-License-Identifier: Apache-2.0
// The fault matrix's camera, odometry and line: each fails in the whole robot, in lockstep, while it explores. What
// counts is how the simulated body really moves: it stands within the cell's deadline, moves no farther than the cell
// allows after that, and goes on by itself where that is safe.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "hal/frame_pool.hpp"
#include "hal/sim/load_world.hpp"
#include "hal/sim/observable.hpp"
#include "hal/sim/sim_building.hpp"
#include "nav/robot.hpp"
#include "tests/support/fault_cells.hpp"

using namespace g3d;
using test::After;
using test::FaultCell;
using test::kFaultCells;
using test::Safe;

namespace {

constexpr hal::TimeNs kMs = 1'000'000;
constexpr hal::TimeNs kLine_ns = 20 * kMs;
constexpr hal::TimeNs kFault_ns = 5'000 * kMs;
constexpr int kLinesPerFrame = 5;    // 10 Hz
constexpr double kFast_mps = 0.35;   // what it drives at, at least, when the fault begins
constexpr double kBraking_s = 0.27;  // of the body, from 0.5 m/s, after the zeros have arrived

bool is_lockstep(const FaultCell& cell) { return !std::string_view(cell.fault).starts_with("disk:"); }

/// A building and the robot in it, in lockstep.
struct Run {
  explicit Run(std::uint64_t seed, const hal::FaultPlan& faults = {}) {
    hal::World world = hal::load_world("house").value();
    config.T_world_start = hal::choose_starts(world, 1, seed).value()[0];
    hal::SimBuildingOptions options;
    options.camera = hal::scaled_kinect(160, 120);
    options.seed = seed;
    options.faults = faults;
    hal::SimRobotOptions body;
    body.T_world_base = config.T_world_start;
    body.base.seed = seed;
    options.robots = {body};
    config.camera = options.camera;
    config.T_base_camera = body.T_base_camera;
    config.navigator.ground.centre_x_m = config.T_world_start.x_m;
    config.navigator.ground.centre_y_m = config.T_world_start.y_m;
    building = std::make_unique<hal::SimBuilding>(std::move(world), options);
    robot = std::make_unique<nav::Robot>(config, clock);
    frame = hal::make_frame(config.camera);
  }
  void step() {
    building->advance_to(now_ns);
    robot->on_line(building->line(0), now_ns);
    if (lines++ % kLinesPerFrame == 0) {
      building->render(0, frame);
      frame.stamp_ns = now_ns;
      if (building->pass_on(0, frame, now_ns)) robot->on_frame(frame, now_ns);
    }
    now_ns += kLine_ns;
  }
  void run_until(hal::TimeNs end_ns) {
    while (now_ns < end_ns) step();
  }
  [[nodiscard]] double speed_mps() const { return building->body(0).velocity().forward_mps; }
  [[nodiscard]] bool stands() const {
    const hal::Twist v = building->body(0).velocity();
    return std::abs(v.forward_mps) < 0.01 && std::abs(v.turn_radps) < 0.02;
  }
  [[nodiscard]] double driven_m() const { return building->record(0).driven_m; }
  [[nodiscard]] double moved() const { return driven_m() + 0.2 * building->record(0).turned_rad; }
  [[nodiscard]] double odometry_error_m() const {
    const hal::PlanarPose truth = building->T_world_base(0), own = robot->T_world_base();
    return std::hypot(truth.x_m - own.x_m, truth.y_m - own.y_m);
  }

  hal::RealClock clock;
  nav::RobotConfig config;
  std::unique_ptr<hal::SimBuilding> building;
  std::unique_ptr<nav::Robot> robot;
  hal::Frame frame;
  hal::TimeNs now_ns = 0;
  int lines = 0;
};

/// When it is exploring at speed; the same in every run of this seed, as faults begin only then.
hal::TimeNs fast_at_ns(std::uint64_t seed) {
  Run run(seed);
  run.run_until(12'000 * kMs);
  while (run.speed_mps() < kFast_mps) run.step();
  return run.now_ns;
}

void check_cell(const FaultCell& cell, std::uint64_t seed, hal::TimeNs begin_ns) {
  INFO(cell.fault << ", seed " << seed);
  hal::PlannedFault fault = hal::parse_fault(cell.fault).value();
  fault.from_ns = begin_ns;
  fault.to_ns = begin_ns + kFault_ns;
  Run run(seed, {fault});
  run.run_until(begin_ns);
  REQUIRE(run.speed_mps() >= kFast_mps);

  const auto deadline_ns = static_cast<hal::TimeNs>((cell.notices_s + kBraking_s) * 1e9);
  const hal::TimeNs due_ns = (cell.safe == Safe::out_of_reach ? fault.to_ns : begin_ns) + deadline_ns;
  const double top_mps = 0.5;
  const auto drive_until = [&](hal::TimeNs end_ns) {
    while (run.now_ns < end_ns) {
      run.step();
      CHECK(std::abs(run.speed_mps()) <= top_mps + 0.05);
    }
  };
  if (cell.safe == Safe::out_of_reach) {
    drive_until(begin_ns + deadline_ns);
    CHECK(run.robot->base().commanded == hal::Twist{});  // it would, if anybody could hear it
    drive_until(fault.to_ns + static_cast<hal::TimeNs>(cell.notices_s * 1e9));
    CHECK(run.building->kobuki(0).drive() == hal::kobuki::BaseControl{});
    // It may drive again once it has heard five packets, and from zero: until then the body has only braked.
    drive_until(due_ns);
    CHECK(run.speed_mps() <= run.robot->base().commanded.forward_mps + 0.1);
  } else {
    if (cell.safe == Safe::stands) {
      while (run.now_ns < due_ns && !run.stands()) run.step();
      CHECK(run.stands());
    }
    const double stood_m = run.driven_m();
    drive_until(fault.to_ns);
    CHECK(run.driven_m() - stood_m <= cell.creep_m + 0.01);
    CHECK(run.building->record(0).contacts == 0);
  }

  const double before = run.moved();
  // Encoders that were dead are tried again after up to 4 s by then, and 8 s if that was too early.
  run.run_until(std::max(run.now_ns, fault.to_ns) + 15'000 * kMs);
  if (cell.after == After::goes_on) {
    CHECK(run.moved() - before > 0.5);
  } else {
    CHECK(run.moved() - before < 0.01);
  }
  if (cell.safe != Safe::out_of_reach) CHECK(run.building->record(0).contacts_measurable == 0);
}

}  // namespace

TEST_CASE("the matrix has every kind of fault of every part", "[system][faults]") {
  std::set<std::string> named;
  for (const FaultCell& cell : kFaultCells) {
    const auto fault = hal::parse_fault(cell.fault);
    REQUIRE(fault.ok());
    named.insert(cell.fault);
  }
  CHECK(named.size() == 28);
  CHECK(std::size(kFaultCells) == 28);
}

TEST_CASE("camera, odometry and line: it stands in time, and goes on where that is safe", "[system][faults]") {
  const hal::TimeNs begin_ns = fast_at_ns(1);
  for (const FaultCell& cell : kFaultCells)
    if (is_lockstep(cell)) check_cell(cell, 1, begin_ns);
}

TEST_CASE("the same from other starts", "[.soak][faults]") {
  for (const std::uint64_t seed : {2, 3, 4, 5, 6}) {
    const hal::TimeNs begin_ns = fast_at_ns(seed);
    for (const FaultCell& cell : kFaultCells)
      if (is_lockstep(cell)) check_cell(cell, seed, begin_ns);
  }
}

TEST_CASE("encoders that fail cost little before they are found out", "[system][faults]") {
  const hal::TimeNs begin_ns = fast_at_ns(1);
  struct Error {
    const char* fault;
    double most_m;
  };
  for (const Error& e : {Error{"odometry:off", 0.4}, Error{"odometry:wrong", 0.2}, Error{"odometry:stuck", 0.02},
                         Error{"odometry:garbage", 0.02}, Error{"line:wrong", 0.05}, Error{"line:stuck", 0.02}}) {
    INFO(e.fault);
    hal::PlannedFault fault = hal::parse_fault(e.fault).value();
    fault.from_ns = begin_ns;
    fault.to_ns = begin_ns + kFault_ns;
    Run run(1, {fault});
    run.run_until(fault.to_ns + 5'000 * kMs);
    CHECK(run.odometry_error_m() < e.most_m);
  }
}

TEST_CASE("a silence is not taken for something that the robot has run into", "[system][faults]") {
  const hal::TimeNs begin_ns = fast_at_ns(1);
  hal::PlannedFault fault = hal::parse_fault("line:stuck").value();
  fault.from_ns = begin_ns;
  fault.to_ns = begin_ns + kFault_ns;
  Run run(1, {fault});
  run.run_until(begin_ns);
  const auto troubles = run.robot->navigator().report().stops[static_cast<std::size_t>(nav::StopReason::no_progress)];
  run.run_until(fault.to_ns + 2'000 * kMs);
  CHECK(run.robot->navigator().report().stops[static_cast<std::size_t>(nav::StopReason::no_progress)] == troubles);
}
