// SPDX-License-Identifier: Apache-2.0
// What an exploration says about itself: the "exploration" object of report.json and the lines of the summary.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mapper/json_writer.hpp"
#include "nav/explained.hpp"
#include "nav/mission_report.hpp"

namespace g3d::hal {
struct RobotRecord;
}

namespace g3d::nav {

/// A touch, as somebody outside of the robot saw it.
struct ContactSeen {
  double time_s = 0.0;
  double x_m = 0.0;  ///< where
  double y_m = 0.0;
  double speed_mps = 0.0;         ///< of the robot, forward or backward
  std::uint8_t bumper_flags = 0;  ///< kobuki's; 0: behind, or above the bumper
  std::int32_t solid = -1;        ///< which of the world's primitives; -1: a wall of its grid
  bool is_moving = false;         ///< a person or another robot
  bool is_measurable = false;     ///< the camera could have measured it beforehand
  bool is_run_into = false;       ///< the robot stood still, and who moves came against it
};

/// What only somebody outside of the robot knows: a simulation. Nothing of it on a real one.
struct OutsideView {
  std::uint64_t contacts = 0;             ///< with anything, however softly
  std::uint64_t contacts_measurable = 0;  ///< of these, with what the camera could have measured beforehand
  std::uint64_t contacts_moving = 0;      ///< with people and robots
  std::uint64_t contacts_ran_into = 0;    ///< of these, while the robot stood; the other counts have them, too
  double fastest_contact_mps = 0.0;
  double closest_clearance_m = 0.0;
  std::vector<ContactSeen> contact_list;  ///< in order of time; the first of them if there are very many
};

[[nodiscard]] OutsideView outside_view(const hal::RobotRecord& record);

struct ExplorationReport {
  const MissionReport* mission = nullptr;
  double time_s = 0.0;  ///< from the first pose to the end
  bool home = false;    ///< it stands where it began
  std::string state;    ///< of the mission, at the end
  std::optional<OutsideView> outside;
  std::vector<std::pair<std::string, std::uint64_t>> safety_stops;  ///< how often each condition began to hold
};

/// Writes the key and the object.
void write_exploration(mapper::JsonWriter& json, const ExplorationReport& report);
/// Some lines that end with a new line.
[[nodiscard]] std::string exploration_text(const ExplorationReport& report);
/// One line for the picture, lower case.
[[nodiscard]] std::string exploration_title(std::string_view world, const ExplorationReport& report);

}  // namespace g3d::nav
