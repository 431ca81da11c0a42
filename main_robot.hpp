// SPDX-License-Identifier: Apache-2.0
// What the board and the command line say of a robot that drives itself, and what its base has to say at the end.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "board/board.hpp"
#include "hal/kobuki/base_thread.hpp"
#include "hal/linux/control_socket.hpp"
#include "hal/result.hpp"
#include "hal/sim/fault_plan.hpp"
#include "hal/sim/sim_building.hpp"
#include "main_commands.hpp"
#include "mapper/json_writer.hpp"
#include "mapper/summary.hpp"
#include "nav/exploration_report.hpp"
#include "nav/hotline.hpp"
#include "nav/robot.hpp"
#include "nav/robot_threads.hpp"

namespace g3d {

struct CameraChoice {
  hal::CameraModel model;
  double rate_hz = 30.0;
};

/// `text`: "160x120@10", or empty for the board's camera. Errors: bad_usage.
[[nodiscard]] hal::Result<CameraChoice> choose_camera(const board::Board& board, const std::string& text);
/// `text`: "X0,Y0,X1,Y1", or empty for no limit. Errors: bad_usage.
[[nodiscard]] hal::Result<void> set_area(const std::string& text, nav::ExplorerConfig& explorer);
[[nodiscard]] nav::RobotConfig robot_config(const board::Board& board, const MappingOptions& options,
                                            const hal::CameraModel& camera, const hal::PlanarPose& T_world_start);
/// What the options say is to happen. Errors: bad_usage.
struct Staging {
  hal::FaultPlan faults;
  std::vector<nav::TimedWord> words;  ///< in order of time
};
[[nodiscard]] hal::Result<Staging> read_staging(const StagingOptions& options);
/// The simulated base's.
[[nodiscard]] hal::BaseDrift drift_like(const std::string& name);
void set_battery(hal::SimKobukiOptions& base, const StagingOptions& options);
/// What is asked before the robot itself; nothing: it is for the robot. Called by the socket's thread.
using AskedFirst = std::function<std::optional<std::string>(std::string_view request)>;
/// None where nobody asked for one and there is no folder for it. Errors: those of ControlSocket.
[[nodiscard]] hal::Result<std::unique_ptr<hal::ControlSocket>> open_control(const StagingOptions& options,
                                                                            const std::string& out_dir,
                                                                            nav::Hotline& hotline,
                                                                            const AskedFirst& first = {});
/// Writes the key "control" and the object: what people said.
void write_control(mapper::JsonWriter& json, const nav::Hotline& hotline, const hal::ControlCounts& counts);
/// Writes the key "cpu_s" and the object: CPU time of each thread in seconds, of the whole process, and of the robot
/// alone, in cores: without what it costs to read or simulate a frame.
void write_cpu(mapper::JsonWriter& json, std::span<const nav::ThreadTime> times, double run_s);

/// What kept the base from moving, and how often it began to, in the order of the safety table.
[[nodiscard]] std::vector<std::pair<std::string, std::uint64_t>> safety_stops(const hal::kobuki::BaseState& base);

/// exploration.png: the way, what is left, and the coverage. `place`: what the picture calls the building.
[[nodiscard]] hal::Result<mapper::WrittenFile> write_picture(const nav::ExplorationReport& explored,
                                                             const nav::Navigator& navigator,
                                                             std::span<const hal::Pose> poses, const std::string& place,
                                                             const std::string& path);

/// How the base and its line did.
struct BaseReport {
  std::string line;         ///< the port's path
  std::string low_latency;  ///< whether the port granted it
  hal::kobuki::BaseState state;
  hal::kobuki::BaseThreadHealth health;
  std::uint64_t refused_writes = 0;
  bool guard_was_alive = false;  ///< until the end
  bool stands = false;           ///< zero speed was the last that was sent
};
/// Writes the key "base" and the object.
void write_base(mapper::JsonWriter& json, const BaseReport& report);

}  // namespace g3d
