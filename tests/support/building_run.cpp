// SPDX-License-Identifier: Apache-2.0
#include "tests/support/building_run.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "board/board.hpp"
#include "hal/clock.hpp"
#include "hal/frame_pool.hpp"
#include "hal/sim/load_world.hpp"
#include "hal/sim/sim_building.hpp"
#include "mapper/mapper.hpp"
#include "nav/coverage.hpp"
#include "nav/robot.hpp"

namespace g3d::tests {
namespace {

constexpr hal::TimeNs kFrame_ns = 100'000'000;
constexpr hal::TimeNs kSecond_ns = 1'000'000'000;

nav::RobotConfig usual_robot(const hal::PlanarPose& start, const hal::CameraModel& camera) {
  const board::Board board;
  nav::RobotConfig config;
  config.mapper.resolution_m = static_cast<float>(board.map_resolution_m);
  config.mapper.steps = {static_cast<std::uint8_t>(board.map_hit), static_cast<std::uint8_t>(board.map_miss)};
  config.mapper.threads = 1;
  config.mapper.capacity = mapper::capacity_for_bytes(static_cast<std::size_t>(board.map_memory_mb) * 1'000'000);
  config.camera = camera;
  config.T_base_camera = hal::forward_camera(board.mount_z_m);
  config.T_world_start = start;
  config.robot_height_m = board.robot_height_m;
  config.navigator = usual_navigator(start);
  config.navigator.ground.max_slots = config.mapper.capacity.blocks;
  config.navigator.explorer.view_rad = 2.0 * std::atan(0.5 * camera.width_px / static_cast<double>(camera.fx_px));
  return config;
}

}  // namespace

nav::NavigatorConfig usual_navigator(const hal::PlanarPose& start) {
  const board::Board board;
  nav::NavigatorConfig navigator;
  navigator.ground.centre_x_m = start.x_m;
  navigator.ground.centre_y_m = start.y_m;
  navigator.ground.heights.body_height_m = board.robot_height_m;
  navigator.ground.speckle_level = static_cast<std::uint8_t>(mapper::kUnknownLevel + board.map_hit);
  navigator.explorer.body_radius_m = board.robot_radius_m;
  navigator.explorer.camera_forward_m = board.mount_x_m;
  navigator.explorer.near_m = board.map_near_m;
  navigator.explorer.far_m = board.map_far_m;
  navigator.follower.limits.body_radius_m = board.robot_radius_m;
  navigator.near_watch.body_radius_m = board.robot_radius_m;
  navigator.near_watch.forward_m = board.mount_x_m;
  navigator.near_watch.near_m = board.map_near_m;
  return navigator;
}

hal::Result<Building> load_building(const std::string& name_or_file, std::uint64_t seed) {
  auto world = hal::load_world(name_or_file);
  if (!world) return world.error();
  const auto starts = hal::choose_starts(world.value(), 1, seed);
  if (!starts) return starts.error();
  auto observable = hal::find_observable(world.value(), starts.value());
  if (!observable) return observable.error();
  return Building{std::move(world).value(), starts.value()[0], std::move(observable).value()};
}

BuildingRun run_in_building(const Building& building, const BuildingRunOptions& options) {
  hal::SimBuildingOptions building_options;
  building_options.camera = hal::scaled_kinect(160, 120);
  building_options.seed = options.seed;
  nav::RobotConfig config = usual_robot(building.start, building_options.camera);
  if (options.change) options.change(config.navigator);
  hal::SimRobotOptions robot_options;
  robot_options.T_world_base = building.start;
  robot_options.T_base_camera = config.T_base_camera;
  robot_options.base.seed = options.seed;
  building_options.robots = {robot_options};
  hal::SimBuilding sim(building.world, building_options);
  hal::RealClock clock;
  nav::Robot robot(config, clock);
  const nav::CoverageMeter coverage(building.observable);
  hal::Frame frame = hal::make_frame(building_options.camera);

  BuildingRun run;
  hal::TimeNs now = 0, next_line_ns = 0, next_frame_ns = 0, next_sample_ns = 0;
  const hal::TimeNs limit_ns = static_cast<hal::TimeNs>(options.limit_s * 1e9);
  nav::MissionReport& report = robot.navigator().report();
  while (now < limit_ns && !robot.navigator().mission().is_over() && run.coverage < options.enough) {
    now = std::min(next_line_ns, next_frame_ns);
    sim.advance_to(now);
    if (now == next_line_ns) {
      robot.on_line(sim.line(0), now);
      next_line_ns += hal::kobuki::kPacketPeriod_ns;
    }
    if (now == next_frame_ns) {
      sim.render(0, frame);
      frame.stamp_ns = now;
      robot.on_frame(frame, now);
      next_frame_ns += kFrame_ns;
    }
    if (now < next_sample_ns) continue;
    run.coverage = coverage.fraction(robot.navigator().ground().states());
    report.note_coverage(run.coverage, now);
    next_sample_ns = now + kSecond_ns;
    if (options.every_second) options.every_second(report.time_s(now), run.coverage, robot.navigator());
  }
  run.t90_s = report.time_to_s(0.90);
  run.t95_s = report.time_to_s(0.95);
  run.t99_s = report.time_to_s(0.99);
  run.end_s = report.time_s(now);
  run.path_m = report.path_m;
  run.rotation_rad = report.rotation_rad;
  run.goals_failed = report.goals_failed;
  run.is_home = robot.navigator().mission().is_over();
  return run;
}

}  // namespace g3d::tests
