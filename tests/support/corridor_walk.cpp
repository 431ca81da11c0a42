// SPDX-License-Identifier: Apache-2.0
#include "tests/support/corridor_walk.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "hal/geometry.hpp"

namespace g3d::tests {
namespace {

constexpr double kHalfWidth_m = 1.2;
constexpr double kHeight_m = 2.4;
constexpr double kHalfPi = 1.5707963267948966;

/// How far along the ray the walls stand. Niches: a third of each 4 m of wall stands half a metre farther back.
double ray_length(const std::array<double, 3>& from, const std::array<double, 3>& along) {
  double best = 1e9;
  if (std::abs(along[2]) > 1e-9) best = std::min(best, ((along[2] > 0 ? kHeight_m : 0.0) - from[2]) / along[2]);
  if (std::abs(along[1]) > 1e-9) {
    const double side = along[1] > 0 ? 1.0 : -1.0;
    double t = (side * kHalfWidth_m - from[1]) / along[1];
    const double x = from[0] + t * along[0];
    if (x - 4.0 * std::floor(x / 4.0) < 1.3) t = (side * (kHalfWidth_m + 0.5) - from[1]) / along[1];
    best = std::min(best, t);
  }
  return best;
}

}  // namespace

hal::CameraModel CorridorWalk::camera() {
  return {.width_px = 64, .height_px = 48, .fx_px = 52, .fy_px = 52, .cx_px = 31.5F, .cy_px = 23.5F};
}

hal::Pose CorridorWalk::pose(int frame) const {
  const double way = static_cast<double>(frame) * step_m;
  const double turn = way - 2.0 * length_m * std::floor(way / (2.0 * length_m));
  const bool back = turn > length_m;
  const double x = back ? 2.0 * length_m - turn : turn;
  const double yaw = 0.8 * std::sin(0.7 * way) + (back ? 2.0 * kHalfPi : 0.0);
  return hal::from_xyz_rpy(x, 0.3 * std::sin(0.2 * way), 1.1, -kHalfPi, 0.0, yaw - kHalfPi);
}

void CorridorWalk::draw(const hal::Pose& T_world_camera, hal::Frame& out) const {
  const hal::CameraModel model = camera();
  const hal::RigidTransform T = hal::to_transform(T_world_camera);
  const auto& R = T.rotation;
  const std::array<double, 3> from{static_cast<double>(T.translation_m[0]), static_cast<double>(T.translation_m[1]),
                                   static_cast<double>(T.translation_m[2])};
  out.has_colour = true;
  for (int v = 0; v < model.height_px; ++v) {
    for (int u = 0; u < model.width_px; ++u) {
      const float sx = (static_cast<float>(u) - model.cx_px) / model.fx_px;
      const float sy = (static_cast<float>(v) - model.cy_px) / model.fy_px;
      std::array<double, 3> along;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        along[axis] = static_cast<double>(R[3 * axis] * sx + R[3 * axis + 1] * sy + R[3 * axis + 2]);
      }
      const double z_m = ray_length(from, along);
      const auto pixel = static_cast<std::size_t>(v * model.width_px + u);
      out.depth[pixel] = z_m < 8.0 ? static_cast<std::uint16_t>(z_m * 1000.0 + 0.5) : std::uint16_t{0};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        out.rgb[3 * pixel + axis] =
            static_cast<std::uint8_t>(static_cast<int>(std::floor((from[axis] + z_m * along[axis]) * 20.0)) & 0xFF);
      }
    }
  }
}

}  // namespace g3d::tests
