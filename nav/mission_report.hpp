// SPDX-License-Identifier: Apache-2.0
// What is told of an exploration afterwards: way, turning, contacts, stops by reason, goals, frontiers left, and the
// coverage over time, which somebody who knows the building samples from outside.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "hal/messages.hpp"
#include "hal/twist.hpp"
#include "nav/explained.hpp"

namespace g3d::nav {

using hal::TimeNs;

enum class StopReason : std::uint8_t {
  contact,      ///< a bumper was pressed
  safety,       ///< the safety table forbade the motion
  shut,         ///< something stood in the way
  no_progress,  ///< commanded, but did not move
  no_path,      ///< nowhere to go from here
  held,         ///< paused, stopped or waiting for help
  teammate,     ///< waited for another robot
};
inline constexpr std::size_t kStopReasons = 7;
[[nodiscard]] std::string_view name_of(StopReason reason);

struct CoverageSample {
  double time_s = 0.0;    ///< since the first pose
  double fraction = 0.0;  ///< of what is observable
  double path_m = 0.0;    ///< driven until then
};

class MissionReport {
 public:
  /// Memory for that many samples is reserved; later ones replace the last.
  explicit MissionReport(std::size_t max_samples = 16384);

  void note_pose(const hal::PlanarPose& T_world_base, TimeNs now);
  void note_coverage(double fraction, TimeNs now);
  void note_stop(StopReason reason) { ++stops[static_cast<std::size_t>(reason)]; }

  [[nodiscard]] double time_s(TimeNs now) const;
  /// When the coverage first was at least this, by the samples.
  [[nodiscard]] std::optional<double> time_to_s(double fraction) const;
  [[nodiscard]] const std::vector<CoverageSample>& coverage() const { return coverage_; }

  double path_m = 0.0;
  double rotation_rad = 0.0;
  std::array<std::uint32_t, kStopReasons> stops{};
  std::uint32_t goals_reached = 0;
  std::uint32_t goals_failed = 0;
  std::uint32_t paths_planned = 0;
  std::uint32_t recoveries = 0;
  FrontiersLeft frontiers_left;  ///< as of the last decision

 private:
  std::vector<CoverageSample> coverage_;
  hal::PlanarPose last_pose_;
  TimeNs start_ns_ = 0;
  bool has_pose_ = false;
};

}  // namespace g3d::nav
