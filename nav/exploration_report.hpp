// SPDX-License-Identifier: Apache-2.0
// What an exploration says about itself: the "exploration" object of report.json and the lines of the summary.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mapper/json_writer.hpp"
#include "nav/explained.hpp"
#include "nav/mission_report.hpp"

namespace g3d::nav {

/// What only somebody outside of the robot knows: a simulation. Nothing of it on a real one.
struct OutsideView {
  std::uint64_t contacts = 0;             ///< with anything, however softly
  std::uint64_t contacts_measurable = 0;  ///< of these, with what the camera could have measured beforehand
  std::uint64_t contacts_moving = 0;      ///< with people and robots
  double fastest_contact_mps = 0.0;
  double closest_clearance_m = 0.0;
};

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

}  // namespace g3d::nav
