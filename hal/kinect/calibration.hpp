// SPDX-License-Identifier: Apache-2.0
// What was measured of one Kinect, as a TOML file. All keys may be left out; without a file the defaults are those of a
// typical Kinect 360, good enough to start.
//
//   serial = "A00364A12345678A"        # for people: not compared
//   [colour]                           # intrinsics of the colour camera: those of registered depth as well
//   fx_px = 525.0  fy_px = 525.0  cx_px = 319.5  cy_px = 239.5
//   [infrared]                         # intrinsics of the infrared camera, where depth is not registered
//   fx_px = 580.0  fy_px = 580.0  cx_px = 319.5  cy_px = 239.5
//   shift_x_px = 0.0  shift_y_px = 0.0 # by how much the depth image lies to the right of and below the infrared one
//   [colour_from_infrared]             # where a point of the infrared camera's frame lies in the colour camera's
//   x_m = -0.025  y_m = 0.0  z_m = 0.0  roll_deg = 0.0  pitch_deg = 0.0  yaw_deg = 0.0
//   [depth]                            # true depth = offset_m + scale z + quadratic_perm z^2 of the reported depth z
//   offset_m = 0.0  scale = 1.0  quadratic_perm = 0.0
//   [time]
//   latency_ms = 20.0                  # from the moment that an image shows until it arrives
//   [accelerometer]                    # what it reports when the camera looks level, in g; and which way z goes
//   zero_x_g = 0.0  zero_y_g = 0.0  zero_z_g = 0.0  z_forward = 1.0
#pragma once

#include <string>
#include <string_view>

#include "hal/messages.hpp"
#include "hal/result.hpp"

namespace g3d::hal::kinect {

struct Intrinsics {
  double fx_px = 525.0, fy_px = 525.0, cx_px = 319.5, cy_px = 239.5;
  bool operator==(const Intrinsics&) const = default;
};

/// Of 640 x 480 images.
struct Calibration {
  std::string serial;
  Intrinsics colour;
  Intrinsics infrared{580.0, 580.0, 319.5, 239.5};
  double shift_x_px = 0.0, shift_y_px = 0.0;
  // T_colour_infrared, camera optical frames; roll about x, pitch about y, yaw about z
  double x_m = -0.025, y_m = 0.0, z_m = 0.0;
  double roll_deg = 0.0, pitch_deg = 0.0, yaw_deg = 0.0;
  double depth_offset_m = 0.0, depth_scale = 1.0, depth_quadratic_perm = 0.0;
  double latency_ms = 20.0;
  double zero_x_g = 0.0, zero_y_g = 0.0, zero_z_g = 0.0;
  double z_forward = 1.0;  ///< 1 or -1: what the accelerometer's z is along the optical axis
  bool operator==(const Calibration&) const = default;
};

inline constexpr std::size_t kMaxCalibration_bytes = std::size_t{64} << 10;

/// `name` is what errors call it: they say the line, what is wrong and what is allowed.
[[nodiscard]] Result<Calibration> parse_calibration(std::string_view text, std::string_view name);
[[nodiscard]] Result<Calibration> load_calibration(const std::string& path);
/// The file that parse_calibration reads back to the same.
[[nodiscard]] std::string calibration_text(const Calibration& calibration);

/// The camera that registered depth, millimetres, is seen by.
[[nodiscard]] CameraModel colour_model(const Calibration& calibration);
/// The camera that depth is seen by where nobody registers it.
[[nodiscard]] CameraModel infrared_model(const Calibration& calibration);

}  // namespace g3d::hal::kinect
