// SPDX-License-Identifier: Apache-2.0
#include "nav/passer_tracks.hpp"
#include "nav/seconds.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr double kGap_m = 0.3;           // between neighbouring rays' hits: more is another body
constexpr int kLeastRays = 3;            // fewer are noise at edges
constexpr int kMostMissing = 2;          // rays without a reading within one body
constexpr double kPlaceTime_s = 0.12;    // of the filter: how fast a place is believed
constexpr double kVelocityTime_s = 0.4;  // and a velocity
constexpr double kBehindView_m = 0.3;    // looked through so far beyond his place: he is not there
constexpr double kStride_m = 0.05;       // of looking for walls in his way

}  // namespace

std::size_t PasserTracks::gather(const DepthScan& scan, const Rays& wanted, const hal::PlanarPose& pose,
                                 std::array<Sight, kMostSights>& sights) const {
  const double cos_heading = std::cos(pose.heading_rad);
  const double sin_heading = std::sin(pose.heading_rad);
  const auto& rays = scan.rays();
  const auto ray_count = static_cast<int>(rays.size());
  std::size_t count = 0;
  for (int first = 0; first < ray_count; ++first) {
    if (!wanted[static_cast<std::size_t>(first)]) continue;
    int last = first, hits = 0;
    double sum_x_m = 0.0, sum_y_m = 0.0;
    for (int i = first; i < ray_count && i <= last + kMostMissing + 1; ++i) {
      if (!wanted[static_cast<std::size_t>(i)]) continue;
      const DepthScan::Ray& ray = rays[static_cast<std::size_t>(i)];
      const DepthScan::Ray& before = rays[static_cast<std::size_t>(last)];
      if (std::hypot(ray.hit_x_m - before.hit_x_m, ray.hit_y_m - before.hit_y_m) > kGap_m) break;
      last = i;
      ++hits;
      sum_x_m += ray.hit_x_m;
      sum_y_m += ray.hit_y_m;
    }
    if (hits >= kLeastRays && count < sights.size()) {
      const double front_x_m = sum_x_m / hits;
      const double front_y_m = sum_y_m / hits;
      const double away_m = std::hypot(front_x_m - scan.eye_x_m(), front_y_m - scan.eye_y_m());
      const double x_m = front_x_m + config_.depth_m * (front_x_m - scan.eye_x_m()) / away_m;
      const double y_m = front_y_m + config_.depth_m * (front_y_m - scan.eye_y_m()) / away_m;
      sights[count++] = {pose.x_m + cos_heading * x_m - sin_heading * y_m,
                         pose.y_m + sin_heading * x_m + cos_heading * y_m, first > 0 && last + 1 < ray_count};
    }
    first = last;
  }
  return count;
}

PasserTracks::Track* PasserTracks::nearest(const Sight& sight, bool must_have_walked, hal::TimeNs now) {
  Track* best = nullptr;
  double least_m = config_.gate_m;
  for (Track& track : tracks_) {
    if (track.ends_ns <= now || track.seen_ns == now || (must_have_walked && !track.has_walked)) continue;
    const double s = seconds_between(track.seen_ns, now);
    const double away_m =
        std::hypot(track.x_m + s * track.vx_mps - sight.x_m, track.y_m + s * track.vy_mps - sight.y_m);
    if (away_m >= least_m) continue;
    least_m = away_m;
    best = &track;
  }
  return best;
}

PasserTracks::Track& PasserTracks::oldest() {
  return *std::min_element(tracks_.begin(), tracks_.end(),
                           [](const Track& a, const Track& b) { return a.ends_ns < b.ends_ns; });
}

void PasserTracks::follow(Track& track, const Sight& sight, hal::TimeNs now) const {
  const double s = seconds_between(track.seen_ns, now);
  const double place_share = 1.0 - std::exp(-s / kPlaceTime_s);
  const double velocity_share = 1.0 - std::exp(-s / kVelocityTime_s);
  const double ahead_x_m = track.x_m + s * track.vx_mps;
  const double ahead_y_m = track.y_m + s * track.vy_mps;
  const double error_x_m = sight.x_m - ahead_x_m;
  const double error_y_m = sight.y_m - ahead_y_m;
  track.x_m = ahead_x_m + place_share * error_x_m;
  track.y_m = ahead_y_m + place_share * error_y_m;
  // What the image's edge cuts off seems to stand still at the edge.
  if (sight.is_whole && s > 0.0) {
    track.vx_mps += velocity_share * error_x_m / s;
    track.vy_mps += velocity_share * error_y_m / s;
  }
  track.seen_ns = now;
  track.ends_ns = after(now, config_.walks_on_s);
  track.is_in_view = true;
  track.has_walked = track.has_walked || is_walking(track);
  const double walked_m = std::hypot(track.x_m - track.first_x_m, track.y_m - track.first_y_m);
  track.is_sure = track.is_sure || (track.has_walked && walked_m >= config_.surely_walked_m);
}

bool PasserTracks::is_walking(const Track& track) const {
  const double speed_mps = std::hypot(track.vx_mps, track.vy_mps);
  return seconds_between(track.first_ns, track.seen_ns) >= config_.known_after_s && speed_mps >= config_.least_mps &&
         speed_mps <= config_.most_mps;
}

PasserTracks::Guess PasserTracks::guess(const Track& track, hal::TimeNs now) const {
  if (!is_walking(track)) return {track.x_m, track.y_m, 0.0, 0.0};
  const double s = seconds_between(track.seen_ns, now);
  return {track.x_m + s * track.vx_mps, track.y_m + s * track.vy_mps, track.vx_mps, track.vy_mps};
}

// Of somebody who was not seen where he should be.
bool PasserTracks::is_looked_through(const Track& track, const DepthScan& scan, const hal::PlanarPose& pose,
                                     hal::TimeNs now) const {
  const Guess at = guess(track, now);
  const double x_m = at.x_m - pose.x_m;
  const double y_m = at.y_m - pose.y_m;
  const double ahead_m = std::cos(pose.heading_rad) * x_m + std::sin(pose.heading_rad) * y_m - scan.eye_x_m();
  const double left_m = -std::sin(pose.heading_rad) * x_m + std::cos(pose.heading_rad) * y_m - scan.eye_y_m();
  const double bearing_rad = std::atan2(left_m, ahead_m);
  const auto& rays = scan.rays();
  const auto* const ray =
      std::find_if(rays.begin(), rays.end(), [&](const DepthScan::Ray& r) { return r.bearing_rad <= bearing_rad; });
  return ray != rays.begin() && ray != rays.end() && ray->through_m > std::hypot(ahead_m, left_m) + kBehindView_m;
}

// No walls on it. Cells where something came lately are his own.
bool PasserTracks::has_way(const Track& track, const CellGrid<CellState>& states, const MovedLately& moved,
                           hal::TimeNs now) const {
  const Guess at = guess(track, now);
  const double way_m = std::hypot(at.x_m - track.x_m, at.y_m - track.y_m);
  const int strides = static_cast<int>(way_m / kStride_m);
  for (int i = 0; i <= strides; ++i) {
    const double part = strides > 0 ? i * kStride_m / way_m : 0.0;
    const Cell c = states.cell_of(track.x_m + part * (at.x_m - track.x_m), track.y_m + part * (at.y_m - track.y_m));
    if (!states.contains(c)) return false;
    if (i * kStride_m > config_.radius_m && states.at(c) == CellState::occupied && !moved.is_new(c, now)) return false;
  }
  return true;
}

void PasserTracks::look(const DepthScan& scan, const Rays& is_somebody, const Rays& came_lately,
                        const CellGrid<CellState>& states, const MovedLately& moved, const hal::PlanarPose& pose,
                        hal::TimeNs now) {
  std::array<Sight, kMostSights> sights{};
  std::size_t count = gather(scan, is_somebody, pose, sights);
  for (std::size_t i = 0; i < count; ++i) {
    if (Track* track = nearest(sights[i], false, now)) {
      follow(*track, sights[i], now);
    } else {
      oldest() = {sights[i].x_m, sights[i].y_m, 0.0,           0.0,          now, now, after(now, config_.walks_on_s),
                  true,          false,         sights[i].x_m, sights[i].y_m};
    }
  }
  count = gather(scan, came_lately, pose, sights);
  for (std::size_t i = 0; i < count; ++i) {
    if (Track* track = nearest(sights[i], true, now)) follow(*track, sights[i], now);
  }
  for (Track& track : tracks_) {
    if (track.ends_ns <= now || track.seen_ns == now) continue;
    track.is_in_view = false;
    if (!track.has_walked || is_looked_through(track, scan, pose, now) || !has_way(track, states, moved, now)) {
      track.ends_ns = 0;
    }
  }
}

bool PasserTracks::may_come(double x_m, double y_m, hal::TimeNs now) const {
  for (const Track& track : tracks_) {
    if (!track.has_walked || track.ends_ns <= now) continue;
    const Guess at = guess(track, now);
    const double square_m2ps2 = at.vx_mps * at.vx_mps + at.vy_mps * at.vy_mps;
    const bool walks = square_m2ps2 > 0.0;
    const double radius_m = config_.radius_m + (walks ? config_.doubt_mps * seconds_between(track.seen_ns, now) : 0.0);
    const double from_x_m = x_m - at.x_m;
    const double from_y_m = y_m - at.y_m;
    const double along_s =
        walks && !track.is_in_view
            ? std::clamp((from_x_m * at.vx_mps + from_y_m * at.vy_mps) / square_m2ps2, 0.0, config_.ahead_s)
            : 0.0;
    if (std::hypot(from_x_m - along_s * at.vx_mps, from_y_m - along_s * at.vy_mps) <= radius_m) return true;
  }
  return false;
}

bool PasserTracks::may_have_come(double x_m, double y_m, hal::TimeNs now) const {
  return std::any_of(tracks_.begin(), tracks_.end(), [&](const Track& track) {
    const double s = seconds_between(track.seen_ns, now);
    return track.is_sure && s > 0.0 && s < config_.about_s &&
           std::hypot(x_m - track.x_m, y_m - track.y_m) <= config_.radius_m + s * config_.roams_mps;
  });
}

}  // namespace g3d::nav
