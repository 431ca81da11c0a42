// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/motion_prior.hpp"

namespace g3d::mapper::align {
namespace {

constexpr std::array<const char*, 2> kMotionNames{"planar", "free"};
double square(double x) { return x * x; }

void hold_to_floor(const OdometryNoise& noise, double dt_s, Matrix6& information) {
  for (std::size_t i = 0; i < 6; ++i) {
    if (i != 2) information[6 * 2 + i] = information[6 * i + 2] = 0.0;
  }
  information[7 * 2] = 1.0 / (square(noise.height_m_per_root_s) * dt_s);
  information[7 * 3] = information[7 * 4] = 1.0 / (square(noise.tilt_rad_per_root_s) * dt_s);
}

}  // namespace

const char* to_string(Motion motion) { return kMotionNames[static_cast<std::size_t>(motion)]; }

std::optional<Motion> motion_from_string(std::string_view name) {
  for (std::size_t i = 0; i < kMotionNames.size(); ++i) {
    if (name == kMotionNames[i]) return static_cast<Motion>(i);
  }
  return std::nullopt;
}

Matrix6 prior_information(const OdometryNoise& noise, Motion motion, OdometrySource source,
                          const std::array<double, 3>& step_m, double dt_s) {
  Matrix6 information{};
  const double length2 = square(step_m[0]) + square(step_m[1]) + square(step_m[2]);
  double shift2 = square(noise.shift_m_per_root_s) * dt_s;
  double turn2 = square(noise.turn_bias_rad_per_s * dt_s) + square(noise.turn_walk_rad_per_root_s) * dt_s;
  if (source == OdometrySource::none) {
    shift2 = square(noise.unmeasured_mps * dt_s);
    turn2 = square(noise.unmeasured_radps * dt_s);
  }
  const double along = 1.0 / (shift2 + square(noise.along_fraction) * length2);
  const double across = 1.0 / (shift2 + square(noise.across_fraction) * length2);
  // across * I + (along - across) * u u^T, with u the direction of the step.
  for (std::size_t a = 0; a < 3; ++a) {
    information[7 * a] = across;
    for (std::size_t b = 0; b < 3 && length2 > 0.0; ++b) {
      information[6 * a + b] += (along - across) / length2 * (step_m[a] * step_m[b]);
    }
    information[7 * (3 + a)] = 1.0 / turn2;
  }
  if (motion == Motion::planar) hold_to_floor(noise, dt_s, information);
  return information;
}

}  // namespace g3d::mapper::align
