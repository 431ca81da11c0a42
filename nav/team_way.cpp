// SPDX-License-Identifier: Apache-2.0
#include "nav/team_way.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr double kTellStep_m = 0.1;
constexpr std::size_t kTellSteps = static_cast<std::size_t>(kTellFar_m / kTellStep_m) + 2;

double off_line_m(const Waypoint& p, const Waypoint& a, const Waypoint& b) {
  const double dx = b.x_m - a.x_m;
  const double dy = b.y_m - a.y_m;
  const double square_m2 = dx * dx + dy * dy;
  const double part =
      square_m2 > 0.0 ? std::clamp(((p.x_m - a.x_m) * dx + (p.y_m - a.y_m) * dy) / square_m2, 0.0, 1.0) : 0.0;
  return std::hypot(p.x_m - a.x_m - part * dx, p.y_m - a.y_m - part * dy);
}

}  // namespace

WayTold tell_place(const hal::PlanarPose& here) {
  WayTold told;
  told.points[0] = {static_cast<float>(here.x_m), static_cast<float>(here.y_m), 0.0F};
  told.count = 1;
  return told;
}

WayTold tell_way(const PathTrack& track, const hal::PlanarPose& here, double speed_mps, double first_turn_s) {
  WayTold told = tell_place(here);
  const auto tell = [&told](const Waypoint& at, double after_s) {
    told.points[told.count++] = {static_cast<float>(at.x_m), static_cast<float>(at.y_m), static_cast<float>(after_s)};
  };
  if (track.empty()) return told;
  std::array<Waypoint, kTellSteps> at;
  std::array<double, kTellSteps> along_m;
  std::size_t count = 0;
  at[count] = {here.x_m, here.y_m};
  along_m[count++] = 0.0;
  const double far_m = std::min(track.remaining_m(), kTellFar_m);
  for (double s = kTellStep_m; s < far_m && count + 1 < kTellSteps; s += kTellStep_m) {
    at[count] = track.ahead(s);
    along_m[count++] = s;
  }
  at[count] = track.ahead(far_m);
  along_m[count++] = far_m;
  if (far_m <= 0.0) return told;
  if (first_turn_s > 0.0) tell(at[0], first_turn_s);
  // Each straight line as long as it stays near the path.
  std::size_t from = 0;
  while (from + 1 < count && told.count < kMostWayPoints) {
    std::size_t to = from + 1;
    const auto fits = [&](std::size_t end) {
      for (std::size_t i = from + 1; i < end; ++i) {
        if (off_line_m(at[i], at[from], at[end]) > kTellOff_m) return false;
      }
      return true;
    };
    while (to + 1 < count && fits(to + 1)) ++to;
    tell(at[to], first_turn_s + along_m[to] / speed_mps);
    from = to;
  }
  return told;
}

}  // namespace g3d::nav
