// SPDX-License-Identifier: Apache-2.0
#include "nav/body_mask.hpp"

#include <algorithm>
#include <cmath>

#include "hal/frame_pool.hpp"
#include "nav/seconds.hpp"
#include "nav/team_bodies.hpp"

namespace g3d::nav {
namespace {

constexpr double kMaskFresh_s = 1.0;   // an older word does not say well enough where it is
constexpr double kMaskSpare_m = 0.06;  // noise of places and readings
constexpr double kMaskFar_m = 6.0;     // farther readings are not mapped
constexpr double kMaskNear_m = 0.05;   // in front of the camera: the whole picture may be body
constexpr double kMaskAboveFloor_m = 0.04;
constexpr std::uint16_t kTooNear_raw = 1;

}  // namespace

BodyMask::BodyMask(const hal::CameraModel& camera, double height_m)
    : camera_(camera), height_m_(height_m), masked_(hal::make_frame(camera)) {}

void BodyMask::copy(const hal::Frame& frame) {
  const auto pixels = static_cast<std::size_t>(camera_.width_px) * static_cast<std::size_t>(camera_.height_px);
  masked_.stamp_ns = frame.stamp_ns;
  masked_.sequence = frame.sequence;
  masked_.has_colour = frame.has_colour && frame.rgb != nullptr && masked_.rgb != nullptr;
  std::copy_n(frame.depth.get(), pixels, masked_.depth.get());
  if (masked_.has_colour) std::copy_n(frame.rgb.get(), 3 * pixels, masked_.rgb.get());
}

// The pixels that the box around an upright cylinder covers.
BodyMask::Window BodyMask::window_of(const hal::RigidTransform& T, double x_m, double y_m, double radius_m) const {
  Window window;
  double u0 = 1e9, v0 = 1e9, u1 = -1e9, v1 = -1e9;
  bool is_in_front = false, is_beside = false;
  for (int corner = 0; corner < 8; ++corner) {
    const auto px = static_cast<float>(x_m + ((corner & 1) != 0 ? radius_m : -radius_m));
    const auto py = static_cast<float>(y_m + ((corner & 2) != 0 ? radius_m : -radius_m));
    const auto pz = static_cast<float>((corner & 4) != 0 ? height_m_ + kMaskSpare_m : 0.0);
    const float cx = T.rotation[0] * px + T.rotation[1] * py + T.rotation[2] * pz + T.translation_m[0];
    const float cy = T.rotation[3] * px + T.rotation[4] * py + T.rotation[5] * pz + T.translation_m[1];
    const float cz = T.rotation[6] * px + T.rotation[7] * py + T.rotation[8] * pz + T.translation_m[2];
    if (cz < static_cast<float>(kMaskNear_m)) {
      is_beside = true;
      continue;
    }
    is_in_front = true;
    const double u = static_cast<double>(camera_.fx_px * cx / cz + camera_.cx_px);
    const double v = static_cast<double>(camera_.fy_px * cy / cz + camera_.cy_px);
    u0 = std::min(u0, u);
    u1 = std::max(u1, u);
    v0 = std::min(v0, v);
    v1 = std::max(v1, v);
  }
  if (!is_in_front) return window;
  if (is_beside) {  // so near that its corners lie behind the camera
    u0 = v0 = 0.0;
    u1 = camera_.width_px;
    v1 = camera_.height_px;
  }
  window.u0 = static_cast<int>(std::clamp(std::floor(u0), 0.0, static_cast<double>(camera_.width_px)));
  window.v0 = static_cast<int>(std::clamp(std::floor(v0), 0.0, static_cast<double>(camera_.height_px)));
  window.u1 = static_cast<int>(std::clamp(std::ceil(u1) + 1.0, 0.0, static_cast<double>(camera_.width_px)));
  window.v1 = static_cast<int>(std::clamp(std::ceil(v1) + 1.0, 0.0, static_cast<double>(camera_.height_px)));
  window.is_empty = window.u0 >= window.u1 || window.v0 >= window.v1;
  return window;
}

const hal::Frame& BodyMask::without_bodies(const hal::Frame& frame, const hal::Pose& T_world_camera,
                                           const TeamSight& sight) {
  bool is_copied = false;
  const hal::RigidTransform T_camera_world = to_transform(inverse(T_world_camera));
  const hal::RigidTransform T = to_transform(T_world_camera);
  for (std::size_t i = 0; i < sight.count; ++i) {
    const Teammate& mate = sight.mates[i];
    if (std::fabs(seconds_between(mate.told_ns, frame.stamp_ns)) > kMaskFresh_s) continue;
    const Waypoint at = place_at(mate, frame.stamp_ns, frame.stamp_ns);
    const double radius_m = static_cast<double>(mate.radius_m) + doubt_m(mate, frame.stamp_ns) + kMaskSpare_m;
    if (std::hypot(at.x_m - T_world_camera.translation_m[0], at.y_m - T_world_camera.translation_m[1]) > kMaskFar_m) {
      continue;
    }
    const Window window = window_of(T_camera_world, at.x_m, at.y_m, radius_m);
    if (window.is_empty) continue;
    if (!is_copied) copy(frame);
    is_copied = true;
    for (int v = window.v0; v < window.v1; ++v) {
      std::uint16_t* const row =
          &masked_.depth[static_cast<std::size_t>(v) * static_cast<std::size_t>(camera_.width_px)];
      for (int u = window.u0; u < window.u1; ++u) {
        if (row[u] == 0) continue;
        const float z = static_cast<float>(row[u]) / camera_.depth_units_per_metre;
        const float x = (static_cast<float>(u) - camera_.cx_px) / camera_.fx_px * z;
        const float y = (static_cast<float>(v) - camera_.cy_px) / camera_.fy_px * z;
        const double wx =
            static_cast<double>(T.rotation[0] * x + T.rotation[1] * y + T.rotation[2] * z + T.translation_m[0]);
        const double wy =
            static_cast<double>(T.rotation[3] * x + T.rotation[4] * y + T.rotation[5] * z + T.translation_m[1]);
        const double wz =
            static_cast<double>(T.rotation[6] * x + T.rotation[7] * y + T.rotation[8] * z + T.translation_m[2]);
        if (wz < kMaskAboveFloor_m || wz > height_m_ + kMaskSpare_m) continue;
        if (std::hypot(wx - at.x_m, wy - at.y_m) > radius_m) continue;
        row[u] = kTooNear_raw;
        ++masked_pixels_;
      }
    }
  }
  return is_copied ? masked_ : frame;
}

}  // namespace g3d::nav
