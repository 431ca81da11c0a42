// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/camera_memory.hpp"

#include <algorithm>
#include <cmath>

#include "hal/sim/world_query.hpp"

namespace g3d::hal {
namespace {

constexpr int kHeights = 5;             // points of the thing, one above the other
constexpr double kOnSurface_m = 0.05;   // a map cell
constexpr double kMoverRadius_m = 0.4;  // at most, of what walks or drives

/// First thing along the ray that stands still and stops the infrared.
double opaque_distance(const World& world, const std::array<double, 3>& eye_m, const std::array<double, 3>& direction) {
  double nearest = 1e30;
  for (const Primitive& p : world.primitives()) {
    if (p.mover >= 0 || p.material.glass) continue;
    nearest = std::min(nearest, intersect(p, eye_m, direction));
  }
  if (world.grid()) {
    const auto to_float = [](const std::array<double, 3>& v) {
      return std::array<float, 3>{static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
    };
    const auto hit = world.grid()->cast(to_float(eye_m), to_float(direction), GridWalls::kMiss);
    nearest = std::min(nearest, double{hit.t});
  }
  return nearest;
}

}  // namespace

CameraMemory::CameraMemory(const World& world, const CameraModel& camera)
    : world_(world),
      camera_(camera),
      recent_(kRecentFrames),
      recent_ns_(kRecentFrames, -1),
      recent_places_m_(kRecentFrames * world.movers().size()) {
  frames_.reserve(kFrames);
}

void CameraMemory::add(TimeNs time_ns, const Pose& T_world_camera, MoverPlaces places_m) {
  const View view = {T_world_camera.translation_m, to_transform(T_world_camera).rotation};
  const std::size_t slot = seen_ % kRecentFrames;
  recent_[slot] = view;
  recent_ns_[slot] = time_ns;
  std::copy(places_m.begin(), places_m.end(),
            recent_places_m_.begin() + static_cast<std::ptrdiff_t>(slot * world_.movers().size()));
  if (seen_++ % every_ != 0) return;
  if (frames_.size() == kFrames) {
    for (std::size_t i = 0; i < kFrames / 2; ++i) frames_[i] = frames_[2 * i];
    frames_.resize(kFrames / 2);
    every_ *= 2;
  }
  frames_.push_back(view);
}

bool CameraMemory::sees(const View& view, const std::array<double, 3>& point_m, double tolerance_m) const {
  std::array<double, 3> ray{};
  std::array<double, 3> in_camera{};
  for (std::size_t k = 0; k < 3; ++k) ray[k] = point_m[k] - view.eye_m[k];
  for (std::size_t k = 0; k < 3; ++k) {
    in_camera[k] = double{view.rotation[k]} * ray[0] + double{view.rotation[3 + k]} * ray[1] +
                   double{view.rotation[6 + k]} * ray[2];
  }
  const double z = in_camera[2];
  if (z < kNear_m || z > kFar_m) return false;
  const double u = double{camera_.fx_px} * in_camera[0] / z + double{camera_.cx_px};
  const double v = double{camera_.fy_px} * in_camera[1] / z + double{camera_.cy_px};
  if (!(u >= 0.0 && v >= 0.0 && u <= camera_.width_px - 1 && v <= camera_.height_px - 1)) return false;
  const double length_m = std::sqrt(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2]);
  return opaque_distance(world_, view.eye_m, ray) * length_m >= length_m - tolerance_m;
}

bool CameraMemory::could_measure(const FloorContact::Thing& thing, const HeightSlice& slice, TimeNs now_ns) const {
  if (thing.kind == FloorContact::Kind::nothing) return false;
  double low_m = slice.low_m;
  double high_m = slice.high_m;
  if (thing.kind == FloorContact::Kind::grid) {
    low_m = std::max(low_m, double{world_.grid()->z_low_m()});
    high_m = std::min(high_m, double{world_.grid()->z_high_m()});
  } else {
    const Primitive& solid = world_.primitives()[static_cast<std::size_t>(thing.solid)];
    if (solid.material.dark || solid.material.glass) return false;
    low_m = std::max(low_m, underside_m(solid));
    high_m = std::min(high_m, upper_side_m(solid));
  }
  const auto seen_at = [&](const View& view, double x_m, double y_m, double tolerance_m) {
    for (int i = 0; i < kHeights; ++i) {
      const double z_m = low_m + (high_m - low_m) * (i + 0.5) / kHeights;
      if (sees(view, {x_m, y_m, z_m}, tolerance_m)) return true;
    }
    return false;
  };
  if (thing.mover < 0) {
    return std::any_of(frames_.begin(), frames_.end(),
                       [&](const View& view) { return seen_at(view, thing.at.x_m, thing.at.y_m, kOnSurface_m); });
  }
  for (std::size_t slot = 0; slot < kRecentFrames; ++slot) {
    if (recent_ns_[slot] < 0 || recent_ns_[slot] > now_ns - kTooLate_ns) continue;
    const auto& place = recent_places_m_[slot * world_.movers().size() + static_cast<std::size_t>(thing.mover)];
    if (seen_at(recent_[slot], place[0], place[1], kMoverRadius_m)) return true;
  }
  return false;
}

}  // namespace g3d::hal
