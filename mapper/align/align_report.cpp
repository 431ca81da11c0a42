// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/align_report.hpp"

#include <algorithm>
#include <cmath>

#include "mapper/align/pose_step.hpp"

namespace g3d::mapper::align {
namespace {

constexpr std::array<const char*, kAlignOutcomeCount> kOutcomeNames{"first",          "aligned",   "few_samples",
                                                                    "little_overlap", "no_better", "implausible"};
constexpr std::array<const char*, 3> kModeNames{"given", "aligned", "none"};

double root_mean(double sum, std::uint64_t count) {
  return count == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(count));
}

}  // namespace

const char* to_string(AlignOutcome outcome) { return kOutcomeNames[static_cast<std::size_t>(outcome)]; }
const char* to_string(OdometryMode mode) { return kModeNames[static_cast<std::size_t>(mode)]; }

std::optional<OdometryMode> odometry_mode_from_string(std::string_view name) {
  for (std::size_t i = 0; i < kModeNames.size(); ++i) {
    if (name == kModeNames[i]) return static_cast<OdometryMode>(i);
  }
  return std::nullopt;
}

void AlignReport::count(AlignOutcome outcome, const Vector6& correction, bool holds_shift, bool holds_turn) {
  ++frames[static_cast<std::size_t>(outcome)];
  if (!is_corrected(outcome)) return;
  held_shift_frames += holds_shift ? 1 : 0;
  held_turn_frames += holds_turn ? 1 : 0;
  const double shift_m = shift_of(correction);
  const double turn_rad = turn_of(correction);
  largest_shift_m = std::max(largest_shift_m, shift_m);
  largest_turn_rad = std::max(largest_turn_rad, turn_rad);
  shift_square_sum_m2 += shift_m * shift_m;
  turn_square_sum_rad2 += turn_rad * turn_rad;
}

std::uint64_t AlignReport::corrected() const { return frames[static_cast<std::size_t>(AlignOutcome::aligned)]; }
double AlignReport::shift_rms_m() const { return root_mean(shift_square_sum_m2, corrected()); }
double AlignReport::turn_rms_rad() const { return root_mean(turn_square_sum_rad2, corrected()); }

}  // namespace g3d::mapper::align
