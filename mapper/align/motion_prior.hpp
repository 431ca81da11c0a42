// SPDX-License-Identifier: Apache-2.0
// What odometry is trusted for: the information (inverse variance) of each of the six unknowns of one step, as a matrix
// that every solve carries along. Directions in which the scene shows nothing then keep odometry by themselves.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "mapper/align/normal_equations.hpp"

namespace g3d::mapper::align {

enum class Motion : std::uint8_t {
  planar,  ///< a robot on a floor: height, roll and pitch hardly change. They may, for no mount is exact
  free,    ///< a hand-held camera
};
[[nodiscard]] const char* to_string(Motion motion);
[[nodiscard]] std::optional<Motion> motion_from_string(std::string_view name);

enum class OdometrySource : std::uint8_t {
  measured,
  none,  ///< nobody measures motion: the camera is expected where it was, within what it may do in the time
};

/// Standard deviations of odometry's error. Those that grow with a walk are per root second.
struct OdometryNoise {
  double along_fraction = 0.03;        ///< of the step, along it
  double across_fraction = 0.01;       ///< of the step, across it
  double shift_m_per_root_s = 0.002;   ///< in every direction that the motion allows
  double turn_bias_rad_per_s = 0.006;  ///< about the axes that the motion allows
  double turn_walk_rad_per_root_s = 0.01;
  double height_m_per_root_s = 0.001;   ///< planar: floors are nearly even
  double tilt_rad_per_root_s = 0.0015;  ///< planar
  double unmeasured_mps = 0.7;          ///< OdometrySource::none: what a hand does
  double unmeasured_radps = 0.8;
};

/// World axes, order as in NormalSums. `step_m`: odometry's translation of this step in the world; `dt_s` > 0.
[[nodiscard]] Matrix6 prior_information(const OdometryNoise& noise, Motion motion, OdometrySource source,
                                        const std::array<double, 3>& step_m, double dt_s);

}  // namespace g3d::mapper::align
