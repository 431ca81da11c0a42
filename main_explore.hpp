// SPDX-License-Identifier: Apache-2.0
// What exploring in a simulated building needs, whether one robot does it or several.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "board/board.hpp"
#include "hal/replay/trajectory_file.hpp"
#include "hal/sim/observable.hpp"
#include "hal/sim/sim_building.hpp"
#include "hal/twist.hpp"
#include "main_commands.hpp"
#include "main_robot.hpp"
#include "mapper/json_writer.hpp"
#include "mapper/report.hpp"
#include "nav/exploration_report.hpp"
#include "nav/motion_limits.hpp"
#include "nav/outputs.hpp"
#include "nav/robot.hpp"

namespace g3d {

/// The first Ctrl-C asks to stop, the second ends the program.
void catch_stop_signals();
[[nodiscard]] bool is_stop_requested();

/// How far the robot is from where it believes to be, once a second: only a simulation can know.
struct PlaceError {
  double square_sum_m2 = 0.0;
  double largest_m = 0.0;
  double largest_turn_rad = 0.0;
  double last_m = 0.0;
  std::uint64_t count = 0;

  void note(const hal::PlanarPose& truth, const hal::PlanarPose& believed) {
    last_m = std::hypot(truth.x_m - believed.x_m, truth.y_m - believed.y_m);
    square_sum_m2 += last_m * last_m;
    largest_m = std::max(largest_m, last_m);
    largest_turn_rad = std::max(largest_turn_rad, std::abs(nav::wrap_angle(truth.heading_rad - believed.heading_rad)));
    ++count;
  }
  void write(mapper::JsonWriter& json) const;
};

/// A building, and the robots that will be in it.
struct ExploreSetup {
  board::Board board;
  std::string place;  ///< what the building is called
  double rate_hz = 10.0;
  double limit_s = 0.0;
  Staging staging;
  hal::World world;
  hal::Observable observable;
  std::vector<nav::RobotConfig> configs;  ///< one for each robot
  hal::SimBuildingOptions building;
};
/// As the options say, with as many robots. kExitDone, or why not, which has been told; the folder of --out is there
/// then.
[[nodiscard]] int prepare_exploration(const SimOptions& options, ExploreSetup& setup);

/// At the end of a run, seen from the robot and from outside.
[[nodiscard]] nav::ExplorationReport explored_by(const nav::Robot& robot, const hal::RobotRecord& record,
                                                 hal::TimeNs end_ns);
/// All but `write_more` and notes of what was done about it.
[[nodiscard]] mapper::RunReport report_of(const nav::Robot& robot, const SimOptions& options, const board::Board& board,
                                          const nav::Outputs& outputs, const std::string& command_line);

}  // namespace g3d
