// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/walkers.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::hal {
namespace {

constexpr double kSamePlace_m = 0.001;

TimeNs ns_of(double t_s) { return static_cast<TimeNs>(t_s * 1e9); }

double distance_m(const std::array<float, 2>& a, const std::array<float, 2>& b) {
  const double dx = double{a[0]} - double{b[0]};
  const double dy = double{a[1]} - double{b[1]};
  return std::sqrt(dx * dx + dy * dy);
}

}  // namespace

Walkers::Walkers(const World& world, std::size_t count) : world_(world), walkers_(count) {
  for (std::size_t i = 0; i < count; ++i) {
    Walker& walker = walkers_[i];
    const auto& points = world.movers()[i].waypoints;
    walker.begin_s = points.front().t_s;
    walker.end_s = points.back().t_s;
    walker.in_rounds = points.size() > 2 && std::abs(points.front().x_m - points.back().x_m) < kSamePlace_m &&
                       std::abs(points.front().y_m - points.back().y_m) < kSamePlace_m;
    walker.place_m = world.mover_at(i, 0);
  }
  for (const Primitive& p : world.primitives()) {
    if (p.mover < 0 || static_cast<std::size_t>(p.mover) >= count) continue;
    Walker& walker = walkers_[static_cast<std::size_t>(p.mover)];
    walker.radius_m = std::max(walker.radius_m, double{p.half_m[0]});
  }
}

double Walkers::advanced(const Walker& walker, double dt_s) const {
  double t_s = walker.own_time_s + walker.direction * dt_s;
  if (walker.in_rounds) {
    const double round_s = walker.end_s - walker.begin_s;
    if (t_s >= walker.end_s) t_s -= round_s;
    if (t_s < walker.begin_s && walker.direction < 0.0) t_s += round_s;
    return t_s;
  }
  return std::clamp(t_s, 0.0, std::max(walker.end_s, 0.0));
}

void Walkers::step(double dt_s, std::span<const std::array<float, 2>> robots_m, double robot_radius_m) {
  for (std::size_t i = 0; i < walkers_.size(); ++i) {
    Walker& walker = walkers_[i];
    const double next_s = advanced(walker, dt_s);
    const std::array<float, 2> next_m = world_.mover_at(i, ns_of(next_s));
    bool blocked = false;
    for (const auto& robot_m : robots_m) {
      const double after_m = distance_m(next_m, robot_m);
      blocked = blocked || (after_m < walker.radius_m + robot_radius_m + kDistance_m &&
                            after_m < distance_m(walker.place_m, robot_m));
    }
    if (!blocked) {
      walker.own_time_s = next_s;
      walker.place_m = next_m;
      walker.waited_s = 0.0;
      continue;
    }
    walker.waited_s += dt_s;
    if (walker.waited_s < kPatience_s) continue;
    walker.direction = -walker.direction;
    walker.waited_s = 0.0;
  }
}

}  // namespace g3d::hal
