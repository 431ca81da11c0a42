// SPDX-License-Identifier: Apache-2.0
#include "nav/right_of_way.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "nav/seconds.hpp"
#include "nav/team_bodies.hpp"

namespace g3d::nav {
namespace {

constexpr double kPassStep_s = 0.25;
constexpr std::size_t kPassSteps = 48;  // 12 s
constexpr double kFarMates_m = 9.0;     // nobody comes from farther within look_s
constexpr double kGrowing_mps = 0.02;   // of the gap, the farther ahead
constexpr double kNotNearer_m = 0.02;   // whoever is near may go away
constexpr double kQueueStep_m = 0.1;

double between_m(const Waypoint& a, const Waypoint& b) { return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m); }

/// Who has to wait more comes first.
bool is_stricter(const Passage& a, const Passage& b) {
  if (a.kind != b.kind) return a.kind > b.kind;
  return a.kind == Passage::Kind::hold && a.within_m < b.within_m;
}

}  // namespace

bool RightOfWay::goes_first(const TeamSight& sight, const Teammate& mate, hal::TimeNs now) {
  return mate.robot < sight.self && is_under_way(mate, now);
}

Passage RightOfWay::judge(const TeamSight& sight, hal::TimeNs now, const hal::PlanarPose& here, const PathTrack& track,
                          double first_turn_s) const {
  Passage strictest;
  for (std::size_t i = 0; i < sight.count; ++i) {
    const Teammate& mate = sight.mates[i];
    const Waypoint at = place_at(mate, now, now);
    if (std::hypot(at.x_m - here.x_m, at.y_m - here.y_m) > kFarMates_m) continue;
    const bool is_first = goes_first(sight, mate, now);
    if (is_first) {
      const Passage passage = yield(mate, now, here, track, first_turn_s);
      if (is_stricter(passage, strictest)) strictest = passage;
    }
    if (!mate.is_moving) {
      const Passage passage = queue(mate, now, here, track);
      if (is_stricter(passage, strictest)) strictest = passage;
    }
  }
  return strictest;
}

Passage RightOfWay::yield(const Teammate& mate, hal::TimeNs now, const hal::PlanarPose& here, const PathTrack& track,
                          double first_turn_s) const {
  const double bodies_m = config_.body_radius_m + static_cast<double>(mate.radius_m);
  const double doubt = doubt_m(mate, now);
  const auto look_steps = static_cast<int>(config_.look_s / kPassStep_s);
  const auto early = static_cast<int>(config_.early_s / kPassStep_s);
  const auto late = static_cast<int>(config_.late_s / kPassStep_s);
  const int steps = std::min(look_steps + late + 1, static_cast<int>(kPassSteps));
  std::array<Waypoint, kPassSteps> theirs;
  for (int k = 0; k < steps; ++k) {
    theirs[static_cast<std::size_t>(k)] = place_at(mate, now, after(now, k * kPassStep_s));
  }
  const Waypoint start{here.x_m, here.y_m};
  const auto along_at = [&](int k) {
    const double drives_s = std::max(0.0, k * kPassStep_s - first_turn_s);
    return track.empty() ? 0.0 : std::min(drives_s * config_.speed_mps, std::max(0.0, track.remaining_m()));
  };
  const auto mine_at = [&](int k) { return along_at(k) > 0.0 ? track.ahead(along_at(k)) : start; };
  const auto is_out_of_way = [&](const Waypoint& at) {
    return std::all_of(theirs.begin(), theirs.begin() + steps,
                       [&](const Waypoint& p) { return between_m(at, p) >= bodies_m + config_.pass_gap_m + doubt; });
  };
  // Who is near already may go, if it gets no nearer.
  const double near_m = between_m(start, theirs[0]) - kNotNearer_m;
  Passage passage;
  int safe = -1;  // the last of its places on the way where it may wait
  for (int k = 0; k < look_steps && k < steps; ++k) {
    const Waypoint mine = mine_at(k);
    const double gap_m = std::min(bodies_m + config_.gap_m + doubt + kGrowing_mps * k * kPassStep_s, near_m);
    bool meets = false;
    for (int j = std::max(0, k - early); j <= std::min(steps - 1, k + late) && !meets; ++j) {
      meets = between_m(mine, theirs[static_cast<std::size_t>(j)]) < gap_m;
    }
    if (!meets) {
      if (is_out_of_way(mine)) safe = k;
      continue;
    }
    passage.robot = mate.robot;
    passage.is_yielding = true;
    if (safe >= 0) {
      passage.kind = Passage::Kind::hold;
      passage.within_m = along_at(safe);
    } else {
      const bool is_soon = k * kPassStep_s <= config_.room_s;
      passage.kind = is_soon ? Passage::Kind::make_room : Passage::Kind::free;
    }
    return passage;
  }
  return passage;
}

Passage RightOfWay::queue(const Teammate& mate, hal::TimeNs now, const hal::PlanarPose& here,
                          const PathTrack& track) const {
  Passage passage;
  if (track.empty()) return passage;
  const Waypoint body{mate.T_world_base.x_m, mate.T_world_base.y_m};
  const double touch_m = config_.body_radius_m + static_cast<double>(mate.radius_m) + doubt_m(mate, now);
  const double start_m = between_m({here.x_m, here.y_m}, body);
  const double until_m = std::min(config_.stand_look_m, track.remaining_m());
  for (double s = kQueueStep_m; s <= until_m; s += kQueueStep_m) {
    const double apart_m = between_m(track.ahead(s), body);
    if (apart_m >= std::min(touch_m, start_m - kNotNearer_m)) continue;
    passage.kind = Passage::Kind::hold;
    passage.robot = mate.robot;
    passage.within_m = std::max(0.0, s - config_.queue_gap_m);
    return passage;
  }
  return passage;
}

}  // namespace g3d::nav
