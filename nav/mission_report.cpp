// SPDX-License-Identifier: Apache-2.0
#include "nav/mission_report.hpp"

#include <algorithm>
#include <cmath>

#include "nav/motion_limits.hpp"

namespace g3d::nav {

std::string_view name_of(StopReason reason) {
  switch (reason) {
    case StopReason::contact:
      return "contact";
    case StopReason::safety:
      return "safety";
    case StopReason::shut:
      return "shut";
    case StopReason::no_progress:
      return "no_progress";
    case StopReason::no_path:
      return "no_path";
    case StopReason::teammate:
      return "teammate";
    case StopReason::held:
      return "held";
  }
  return "unknown";
}

MissionReport::MissionReport(std::size_t max_samples) { coverage_.reserve(std::max<std::size_t>(max_samples, 1)); }

void MissionReport::note_pose(const hal::PlanarPose& T_world_base, TimeNs now) {
  if (has_pose_) {
    path_m += std::hypot(T_world_base.x_m - last_pose_.x_m, T_world_base.y_m - last_pose_.y_m);
    rotation_rad += std::fabs(wrap_angle(T_world_base.heading_rad - last_pose_.heading_rad));
  } else {
    start_ns_ = now;
    has_pose_ = true;
  }
  last_pose_ = T_world_base;
}

double MissionReport::time_s(TimeNs now) const { return has_pose_ ? static_cast<double>(now - start_ns_) * 1e-9 : 0.0; }

void MissionReport::note_coverage(double fraction, TimeNs now) {
  const CoverageSample sample{time_s(now), fraction, path_m};
  if (coverage_.size() == coverage_.capacity()) {
    coverage_.back() = sample;
  } else {
    coverage_.push_back(sample);
  }
}

std::optional<double> MissionReport::time_to_s(double fraction) const {
  for (const CoverageSample& sample : coverage_) {
    if (sample.fraction >= fraction) return sample.time_s;
  }
  return std::nullopt;
}

}  // namespace g3d::nav
