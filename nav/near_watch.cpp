// SPDX-License-Identifier: Apache-2.0
#include "nav/near_watch.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr std::array kParts{0.1, 0.5, 0.9};  // rays per sector: no cell at 0.8 m is missed
constexpr int kPixelStep = 2;
constexpr double kTeammateGap_m = 0.10;  // of a sector's middle from a body that covers its side

}  // namespace

NearWatch::NearWatch(const CellGrid<CellState>& like, const NearWatchConfig& config)
    : config_(config), until_(like.resolution_m, like.origin_x_m, like.origin_y_m, like.columns, like.rows, 0) {}

bool NearWatch::sees_floor(const hal::Frame& frame, const hal::CameraModel& camera, int sector) const {
  const int first_u = sector * camera.width_px / kSectors;
  const int end_u = (sector + 1) * camera.width_px / kSectors;
  const int first_v = static_cast<int>((1.0 - config_.lowest_rows) * camera.height_px);
  const auto near_raw = static_cast<float>(config_.near_m) * camera.depth_units_per_metre;
  int seen = 0, looked = 0;
  for (int v = first_v; v < camera.height_px; v += kPixelStep) {
    const std::uint16_t* row = &frame.depth[static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width_px)];
    for (int u = first_u; u < end_u; u += kPixelStep) {
      ++looked;
      seen += static_cast<float>(row[u]) >= near_raw ? 1 : 0;
    }
  }
  return seen >= config_.seen_share * looked;
}

double NearWatch::bearing_rad(const hal::PlanarPose& pose, const hal::CameraModel& camera, int sector, double part) {
  const double u_px = (sector + part) * camera.width_px / kSectors;
  return pose.heading_rad - std::atan((u_px - static_cast<double>(camera.cx_px)) / static_cast<double>(camera.fx_px));
}

// The cells below one ray of a sector; `part` 0 is its left border, 1 its right one.
template <typename Visit>
void NearWatch::walk(const hal::PlanarPose& pose, const hal::CameraModel& camera, int sector, double part,
                     double from_m, double to_m, Visit visit) const {
  const double towards_rad = bearing_rad(pose, camera, sector, part);
  const double step_m = 0.5 * until_.resolution_m;
  const double eye_x_m = pose.x_m + config_.forward_m * std::cos(pose.heading_rad);
  const double eye_y_m = pose.y_m + config_.forward_m * std::sin(pose.heading_rad);
  for (double s = from_m; s <= to_m; s += step_m) {
    const Cell c = until_.cell_of(eye_x_m + s * std::cos(towards_rad), eye_y_m + s * std::sin(towards_rad));
    if (!until_.contains(c) || !visit(c)) return;
  }
}

void NearWatch::look(const hal::Frame& frame, const hal::CameraModel& camera, const CellGrid<CellState>& states,
                     const MovedLately& moved, const hal::PlanarPose& pose, TimeNs now, const TeamBodies* teammates) {
  if (camera.width_px < kSectors) return;
  last_pose_ = pose;
  std::array<bool, kSectors> has_floor{};
  for (int sector = 0; sector < kSectors; ++sector) {
    const auto i = static_cast<std::size_t>(sector);
    has_floor[i] = sees_floor(frame, camera, sector);
    bearings_rad_[i] = bearing_rad(pose, camera, sector, 0.5);
    bool is_explained = false;
    if (!has_floor[i]) {
      walk(pose, camera, sector, 0.5, 0.0, config_.explained_m, [&](Cell c) {
        is_explained = states.at(c) == CellState::occupied && !moved.is_new(c, now);
        if (!is_explained && teammates != nullptr) {
          is_explained = teammates->is_known_at(states.centre_x_m(c), states.centre_y_m(c), kTeammateGap_m, now);
        }
        return !is_explained;
      });
    }
    is_suspicious_[i] = !has_floor[i] && !is_explained;
  }
  for (std::size_t first = 0; first < kSectors;) {
    std::size_t end = first;
    while (end < kSectors && is_suspicious_[end]) ++end;
    const bool goes_on_outside = first == 0 || end == kSectors;
    const int least = goes_on_outside ? config_.least_at_edge : config_.least_sectors;
    const bool is_wide = end - first >= static_cast<std::size_t>(least);
    for (; first < end; ++first) is_suspicious_[first] = is_wide;
    ++first;
  }
  const std::uint32_t until = tick(now + static_cast<TimeNs>(config_.hold_s * 1e9));
  for (int sector = 0; sector < kSectors; ++sector) {
    const auto i = static_cast<std::size_t>(sector);
    if (!has_floor[i] && !is_suspicious_[i]) continue;
    for (const double part : kParts) {
      walk(pose, camera, sector, part, config_.body_radius_m, config_.near_m, [&](Cell c) {
        until_.at(c) = has_floor[i] ? 0 : until;
        return true;
      });
    }
  }
}

}  // namespace g3d::nav
