// SPDX-License-Identifier: Apache-2.0
#include "nav/team_bodies.hpp"

#include <algorithm>
#include <cmath>

#include "nav/seconds.hpp"

namespace g3d::nav {
namespace {

constexpr double kDoubtMoving_m = 0.04;  // of where one is who drives as he has told
constexpr double kDoubtGrows_mps = 0.06;
constexpr double kDoubtMost_m = 0.20;
constexpr double kMayHaveStopped_s = 0.4;  // of its last way: a word is late, and whoever drives may brake

}  // namespace

bool is_fresh(const Teammate& mate, hal::TimeNs now) { return now < after(mate.told_ns, kTeamWordFresh_s); }

bool is_under_way(const Teammate& mate, hal::TimeNs now) { return mate.way_count > 1 && is_fresh(mate, now); }

Waypoint place_at(const Teammate& mate, hal::TimeNs now, hal::TimeNs when) {
  if (!is_under_way(mate, now)) return {mate.T_world_base.x_m, mate.T_world_base.y_m};
  const double s = seconds_between(mate.is_moving ? mate.told_ns : now, when);
  const auto at = [&](std::size_t i) {
    return Waypoint{static_cast<double>(mate.way[i].x_m), static_cast<double>(mate.way[i].y_m)};
  };
  std::size_t next = 0;
  while (next < mate.way_count && static_cast<double>(mate.way[next].after_s) <= s) ++next;
  if (next == 0) return {mate.T_world_base.x_m, mate.T_world_base.y_m};
  if (next == mate.way_count) return at(mate.way_count - 1);
  const double from_s = static_cast<double>(mate.way[next - 1].after_s);
  const double part = (s - from_s) / (static_cast<double>(mate.way[next].after_s) - from_s);
  const Waypoint a = at(next - 1);
  const Waypoint b = at(next);
  return {a.x_m + part * (b.x_m - a.x_m), a.y_m + part * (b.y_m - a.y_m)};
}

double doubt_m(const Teammate& mate, hal::TimeNs now) {
  if (!mate.is_moving || !is_fresh(mate, now)) return TeamBodies::kDoubtStanding_m;
  return std::min(kDoubtMoving_m + kDoubtGrows_mps * std::max(0.0, seconds_between(mate.told_ns, now)), kDoubtMost_m);
}

void TeamBodies::look_around(const hal::PlanarPose& here, hal::TimeNs now) {
  disc_count_ = 0;
  for (std::size_t i = 0; i < sight_.count; ++i) {
    const Teammate& mate = sight_.mates[i];
    const bool is_silent = !is_fresh(mate, now);
    if (is_silent && is_gone_[i]) continue;
    const Waypoint middle = place_at(mate, now, now);
    if (std::hypot(middle.x_m - here.x_m, middle.y_m - here.y_m) > kAround_m) continue;
    const double radius_m = static_cast<double>(mate.radius_m) + doubt_m(mate, now);
    const bool drives = mate.is_moving && !is_silent;
    const std::size_t steps = drives ? kMostSteps : 1;
    for (std::size_t step = 0; step < steps; ++step) {
      const double part = static_cast<double>(step) / static_cast<double>(kMostSteps - 1);
      const double ahead_s = drives ? part * (kAhead_s + kMayHaveStopped_s) - kMayHaveStopped_s : 0.0;
      const Waypoint at = place_at(mate, now, after(now, ahead_s));
      discs_[disc_count_++] = {at.x_m, at.y_m, radius_m * radius_m};
    }
  }
}

bool TeamBodies::is_at(const Teammate& mate, double x_m, double y_m, double gap_m, hal::TimeNs now) const {
  const Waypoint at = place_at(mate, now, now);
  const double reach_m = static_cast<double>(mate.radius_m) + doubt_m(mate, now) + gap_m;
  return std::hypot(at.x_m - x_m, at.y_m - y_m) <= reach_m;
}

bool TeamBodies::is_near(double x_m, double y_m, double gap_m, hal::TimeNs now) const {
  for (std::size_t i = 0; i < sight_.count; ++i) {
    const Teammate& mate = sight_.mates[i];
    if (is_gone_[i] && !is_fresh(mate, now)) continue;
    if (is_at(mate, x_m, y_m, gap_m, now)) return true;
  }
  return false;
}

bool TeamBodies::is_known_at(double x_m, double y_m, double gap_m, hal::TimeNs now) const {
  for (std::size_t i = 0; i < sight_.count; ++i) {
    if (is_fresh(sight_.mates[i], now) && is_at(sight_.mates[i], x_m, y_m, gap_m, now)) return true;
  }
  return false;
}

}  // namespace g3d::nav
