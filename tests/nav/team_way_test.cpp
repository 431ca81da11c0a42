// SPDX-License-Identifier: Apache-2.0
#include "nav/team_way.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

using namespace g3d;

namespace {

/// From the nearest straight piece of the way told.
double off_told_m(const nav::WayTold& told, const nav::Waypoint& p) {
  double best_m = 1e9;
  for (std::size_t i = 1; i < told.count; ++i) {
    for (int k = 0; k <= 100; ++k) {
      const double part = k / 100.0;
      const double x_m =
          (1 - part) * static_cast<double>(told.points[i - 1].x_m) + part * static_cast<double>(told.points[i].x_m);
      const double y_m =
          (1 - part) * static_cast<double>(told.points[i - 1].y_m) + part * static_cast<double>(told.points[i].y_m);
      best_m = std::min(best_m, std::hypot(x_m - p.x_m, y_m - p.y_m));
    }
  }
  return best_m;
}

}  // namespace

TEST_CASE("a bent way is told in few points that stay near it, with times that grow", "[nav][team]") {
  std::vector<nav::Waypoint> path;
  for (int i = 0; i <= 60; ++i) path.push_back({0.05 * i, 0.0});
  for (int i = 1; i <= 60; ++i) {  // a quarter of a circle of 2 m
    const double angle_rad = 1.5707963 * i / 60.0;
    path.push_back({3.0 + 2.0 * std::sin(angle_rad), 2.0 - 2.0 * std::cos(angle_rad)});
  }
  nav::PathTrack track;
  track.set(path);
  const nav::WayTold told = nav::tell_way(track, {0.0, 0.0, 0.0}, 0.4, 0.0);
  REQUIRE(told.count >= 3);
  CHECK(told.count <= 8);
  for (std::size_t i = 1; i < told.count; ++i) CHECK(told.points[i].after_s > told.points[i - 1].after_s);
  for (const nav::Waypoint& p : path) CHECK(off_told_m(told, p) < nav::kTellOff_m + 0.02);
  const nav::WayPoint& last = told.points[told.count - 1];
  CHECK(static_cast<double>(last.x_m) == Approx(5.0).margin(1e-3));
  CHECK(static_cast<double>(last.after_s) == Approx(track.length_m() / 0.4).margin(0.1));
}

TEST_CASE("a turn on the spot comes before the way; without a path there is one point", "[nav][team]") {
  nav::PathTrack track;
  CHECK(nav::tell_way(track, {1.0, 2.0, 0.0}, 0.4, 0.0).count == 1);
  track.set(std::vector<nav::Waypoint>{{0.0, 0.0}, {2.0, 0.0}});
  const nav::WayTold told = nav::tell_way(track, {0.0, 0.0, 3.0}, 0.5, 2.0);
  REQUIRE(told.count == 3);
  CHECK(static_cast<double>(told.points[1].x_m) == 0.0);
  CHECK(static_cast<double>(told.points[1].after_s) == 2.0);
  CHECK(static_cast<double>(told.points[2].after_s) == Approx(6.0));
}

TEST_CASE("a way with more bends than there are points is told as far as they reach", "[nav][team]") {
  std::vector<nav::Waypoint> path;
  for (int i = 0; i <= 60; ++i) path.push_back({0.2 * i, i % 4 < 2 ? 0.0 : 0.4});
  nav::PathTrack track;
  track.set(path);
  const nav::WayTold told = nav::tell_way(track, {0.0, 0.0, 0.0}, 0.4, 0.0);
  CHECK(told.count == nav::kMostWayPoints);
}
