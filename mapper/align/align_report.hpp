// SPDX-License-Identifier: Apache-2.0
// What became of the frames that were to be aligned: for report.json.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "mapper/align/normal_equations.hpp"

namespace g3d::mapper::align {

enum class AlignOutcome : std::uint8_t {
  first,           ///< nothing to align to yet
  aligned,         ///< with odometry
  few_samples,     ///< the image shows too little: covered, out of range
  little_overlap,  ///< too little of what it shows has been seen before
  no_better,       ///< it fits no better than where odometry has the camera
  implausible,     ///< farther from odometry than it can be off
  count_,
};
inline constexpr std::size_t kAlignOutcomeCount = static_cast<std::size_t>(AlignOutcome::count_);
[[nodiscard]] const char* to_string(AlignOutcome outcome);
/// False: odometry's step was taken as it is.
[[nodiscard]] constexpr bool is_corrected(AlignOutcome outcome) { return outcome == AlignOutcome::aligned; }

/// Whose word the pose of a frame is.
enum class OdometryMode : std::uint8_t {
  given,    ///< the poses as they come
  aligned,  ///< corrected by alignment
  none,     ///< alignment alone; nobody measures motion
};
[[nodiscard]] const char* to_string(OdometryMode mode);
[[nodiscard]] std::optional<OdometryMode> odometry_mode_from_string(std::string_view name);

struct AlignReport {
  std::array<std::uint64_t, kAlignOutcomeCount> frames{};
  std::uint64_t held_shift_frames = 0;  ///< in which some direction was odometry's
  std::uint64_t held_turn_frames = 0;
  double largest_shift_m = 0.0;  ///< of the corrections of single steps
  double largest_turn_rad = 0.0;
  double shift_square_sum_m2 = 0.0;
  double turn_square_sum_rad2 = 0.0;
  std::uint64_t surface_pieces = 0;
  std::uint64_t refused_samples = 0;   ///< the table of surfaces was full
  std::uint64_t forgotten_pieces = 0;  ///< to make room for others
  // What was learnt of a base, by the last frame: see OdometryHabits and OdometryTrust
  double learnt_turn_radps = 0.0;
  double learnt_stretch = 0.0;
  double turn_noise_scale = 1.0;  ///< of the variance that its turns are taken to have

  void count(AlignOutcome outcome, const Vector6& correction, bool holds_shift, bool holds_turn);
  [[nodiscard]] std::uint64_t corrected() const;
  /// Root mean square over the corrected frames.
  [[nodiscard]] double shift_rms_m() const;
  [[nodiscard]] double turn_rms_rad() const;
};

}  // namespace g3d::mapper::align
