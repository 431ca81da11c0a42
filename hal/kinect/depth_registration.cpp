// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/depth_registration.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hal/geometry.hpp"
#include "hal/kinect/sensor_link.hpp"

namespace g3d::hal::kinect {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;

}  // namespace

DepthRegistration::DepthRegistration(const Calibration& calibration)
    : rays_(static_cast<std::size_t>(kWidth_px) * kHeight_px),
      shift_mm_{static_cast<float>(1000.0 * calibration.x_m), static_cast<float>(1000.0 * calibration.y_m),
                static_cast<float>(1000.0 * calibration.z_m)},
      colour_(calibration.colour) {
  const Pose T_colour_infrared = from_xyz_rpy(0, 0, 0, kRadians * calibration.roll_deg,
                                              kRadians * calibration.pitch_deg, kRadians * calibration.yaw_deg);
  const CameraModel infrared = infrared_model(calibration);
  for (int v = 0; v < kHeight_px; ++v) {
    for (int u = 0; u < kWidth_px; ++u) {
      const algebra::Vector3 ray = algebra::rotate(
          T_colour_infrared.rotation_xyzw,
          {(static_cast<double>(u) - static_cast<double>(infrared.cx_px)) / static_cast<double>(infrared.fx_px),
           (static_cast<double>(v) - static_cast<double>(infrared.cy_px)) / static_cast<double>(infrared.fy_px), 1.0});
      rays_[static_cast<std::size_t>(v * kWidth_px + u)] = {static_cast<float>(ray[0]), static_cast<float>(ray[1]),
                                                            static_cast<float>(ray[2])};
    }
  }
}

void DepthRegistration::apply(const std::uint16_t* infrared_mm, std::uint16_t* colour_mm) const {
  std::fill_n(colour_mm, rays_.size(), std::uint16_t{0});
  const auto fx_px = static_cast<float>(colour_.fx_px), fy_px = static_cast<float>(colour_.fy_px);
  const auto cx_px = static_cast<float>(colour_.cx_px), cy_px = static_cast<float>(colour_.cy_px);
  for (std::size_t i = 0; i < rays_.size(); ++i) {
    if (infrared_mm[i] == 0) continue;
    const auto depth_mm = static_cast<float>(infrared_mm[i]);
    const float z_mm = rays_[i].z * depth_mm + shift_mm_[2];
    if (!(z_mm >= 1.0F && z_mm < 65535.0F)) continue;
    const float u_px = fx_px * (rays_[i].x * depth_mm + shift_mm_[0]) / z_mm + cx_px + 0.5F;
    const float v_px = fy_px * (rays_[i].y * depth_mm + shift_mm_[1]) / z_mm + cy_px + 0.5F;
    if (!(u_px >= 0.0F && u_px < kWidth_px && v_px >= 0.0F && v_px < kHeight_px)) continue;
    std::uint16_t& there_mm = colour_mm[static_cast<std::size_t>(v_px) * kWidth_px + static_cast<std::size_t>(u_px)];
    const auto here_mm = static_cast<std::uint16_t>(z_mm + 0.5F);
    if (there_mm == 0 || here_mm < there_mm) there_mm = here_mm;
  }
}

}  // namespace g3d::hal::kinect
