// SPDX-License-Identifier: Apache-2.0
#include "nav/passers.hpp"

#include <array>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr double kTeammateNoise_m = 0.10;  // of what is measured of a body
constexpr double kBeforeHit_m = 0.1;       // looked through up to here

enum class Known : std::uint8_t { no, lately, yes };

// A reading beside a map's cell is of what stands there. What has moved lately may have come a cell nearer: there the
// cell itself counts alone.
Known known_at(const CellGrid<CellState>& states, const MovedLately& moved, Cell at, hal::TimeNs now) {
  Known known = Known::no;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const Cell c{at.x + dx, at.y + dy};
      if (!states.contains(c) || states.at(c) != CellState::occupied) continue;
      if (!moved.is_new(c, now)) return Known::yes;
      if (c == at) known = Known::lately;
    }
  }
  return known;
}

}  // namespace

Passers::Passers(const CellGrid<CellState>& like, const PassersConfig& config)
    : config_(config),
      until_(like.resolution_m, like.origin_x_m, like.origin_y_m, like.columns, like.rows, 0),
      looked_(like.resolution_m, like.origin_x_m, like.origin_y_m, like.columns, like.rows, 0),
      tracks_(config.tracks) {}

void Passers::look(const DepthScan& scan, const CellGrid<CellState>& states, const MovedLately& moved,
                   const hal::PlanarPose& pose, hal::TimeNs now, const TeamBodies* teammates) {
  const double cos_heading = std::cos(pose.heading_rad);
  const double sin_heading = std::sin(pose.heading_rad);
  const auto cell_at = [&](double x_m, double y_m) {
    return until_.cell_of(pose.x_m + cos_heading * x_m - sin_heading * y_m,
                          pose.y_m + sin_heading * x_m + cos_heading * y_m);
  };
  const double step_m = 0.5 * until_.resolution_m;
  for (const DepthScan::Ray& ray : scan.rays()) {
    const double along_x = std::cos(ray.bearing_rad);
    const double along_y = std::sin(ray.bearing_rad);
    for (double s = config_.body_radius_m; s < ray.through_m - kBeforeHit_m; s += step_m) {
      const Cell c = cell_at(scan.eye_x_m() + s * along_x, scan.eye_y_m() + s * along_y);
      if (!until_.contains(c)) break;
      until_.at(c) = 0;
      looked_.at(c) = tick(now);
    }
  }
  const std::uint32_t until = tick(now + static_cast<hal::TimeNs>(config_.hold_s * 1e9));
  PasserTracks::Rays is_somebody{};
  PasserTracks::Rays came_lately{};
  for (std::size_t i = 0; i < is_somebody.size(); ++i) {
    const DepthScan::Ray& ray = scan.rays()[i];
    if (!ray.has_hit) continue;
    const Cell c = cell_at(ray.hit_x_m, ray.hit_y_m);
    if (!until_.contains(c)) continue;
    if (teammates != nullptr &&
        teammates->is_known_at(until_.centre_x_m(c), until_.centre_y_m(c), kTeammateNoise_m, now)) {
      continue;
    }
    const Known known = known_at(states, moved, c, now);
    is_somebody[i] = known == Known::no;
    came_lately[i] = known == Known::lately;
    if (is_somebody[i]) until_.at(c) = until;
  }
  tracks_.look(scan, is_somebody, came_lately, states, moved, pose, now);
}

}  // namespace g3d::nav
