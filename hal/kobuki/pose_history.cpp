// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/pose_history.hpp"

#include <numbers>

namespace g3d::hal::kobuki {
namespace {

constexpr double kHalfTurn_rad = std::numbers::pi;

/// In (-pi, pi], for an angle not farther than one turn off.
double short_way(double angle_rad) {
  if (angle_rad > kHalfTurn_rad) return angle_rad - 2.0 * kHalfTurn_rad;
  return angle_rad <= -kHalfTurn_rad ? angle_rad + 2.0 * kHalfTurn_rad : angle_rad;
}

}  // namespace

void PoseHistory::add(TimeNs stamp_ns, const PlanarPose& T_world_base) {
  if (count_ > 0 && stamp_ns <= back(0).stamp_ns) return;
  entries_[count_ % kPoses] = {stamp_ns, T_world_base};
  ++count_;
}

std::optional<PlanarPose> PoseHistory::at(TimeNs stamp_ns) const {
  for (std::size_t i = 0; i < size(); ++i) {
    if (back(i).stamp_ns > stamp_ns) continue;
    if (back(i).stamp_ns == stamp_ns) return back(i).T_world_base;
    const bool beyond = i == 0;
    std::size_t before = i;
    if (beyond) {
      // A step of less than a packet's time, and the noise in it would be blown up to metres.
      for (before = 1; before < size() && back(0).stamp_ns - back(before).stamp_ns < kMinStep_ns;) ++before;
      if (before >= size() || stamp_ns - back(0).stamp_ns > kMaxExtrapolation_ns) return std::nullopt;
    }
    const Entry& from = back(before);
    const Entry& to = back(beyond ? 0 : i - 1);
    if (to.stamp_ns - from.stamp_ns > kMaxGap_ns) return std::nullopt;
    const double part =
        static_cast<double>(stamp_ns - from.stamp_ns) / static_cast<double>(to.stamp_ns - from.stamp_ns);
    const PlanarPose &a = from.T_world_base, &b = to.T_world_base;
    return PlanarPose{a.x_m + part * (b.x_m - a.x_m), a.y_m + part * (b.y_m - a.y_m),
                      short_way(a.heading_rad + part * short_way(b.heading_rad - a.heading_rad))};
  }
  return std::nullopt;
}

}  // namespace g3d::hal::kobuki
