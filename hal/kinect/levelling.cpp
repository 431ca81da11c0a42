// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/levelling.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

namespace g3d::hal::kinect {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kArrived_deg = 2.0;

/// Waits until the motor has arrived, at a stop, or patience is over.
Result<TiltState> wait_for_motor(TiltUnit& foot, Clock& clock, const LevellingOptions& options) {
  const TimeNs begin_ns = clock.now();
  for (;;) {
    clock.sleep_until(clock.now() + options.poll_ns);
    auto state = foot.state();
    if (!state) return state;
    const bool has_arrived =
        state.value().knows_tilt && std::abs(state.value().tilt_deg - options.target_deg) <= kArrived_deg;
    if (!state.value().is_moving && (has_arrived || state.value().is_at_stop)) return state;
    if (clock.now() - begin_ns > options.patience_ns) return state;
  }
}

}  // namespace

std::optional<Attitude> attitude_of(const TiltState& state, const Calibration& calibration) {
  const double x_g = state.acceleration_g[0] - calibration.zero_x_g;
  const double y_g = state.acceleration_g[1] - calibration.zero_y_g;
  const double z_g = (state.acceleration_g[2] - calibration.zero_z_g) * calibration.z_forward;
  const double norm_g = std::hypot(x_g, y_g, z_g);
  if (!(norm_g >= 0.9 && norm_g <= 1.1)) return std::nullopt;
  return Attitude{kDegrees * std::atan2(z_g, std::hypot(x_g, y_g)), kDegrees * std::atan2(x_g, y_g)};
}

Result<Levelled> level_camera(TiltUnit& foot, Clock& clock, const Calibration& calibration,
                              const LevellingOptions& options) {
  if (auto moved = foot.tilt_to(options.target_deg); !moved) return moved.error();
  auto arrived = wait_for_motor(foot, clock, options);
  if (!arrived) return arrived.error();
  if (arrived.value().is_moving) return Levelled{std::nullopt, "the Kinect's motor did not come to rest"};

  TiltState mean;
  std::array<double, 3> squares{};
  for (int i = 0; i < options.samples; ++i) {
    clock.sleep_until(clock.now() + options.poll_ns / 4);
    const auto state = foot.state();
    if (!state) return state.error();
    for (std::size_t k = 0; k < 3; ++k) {
      mean.acceleration_g[k] += state.value().acceleration_g[k] / options.samples;
      squares[k] += state.value().acceleration_g[k] * state.value().acceleration_g[k] / options.samples;
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    if (squares[k] - mean.acceleration_g[k] * mean.acceleration_g[k] > options.most_unrest_g * options.most_unrest_g) {
      return Levelled{std::nullopt, "the Kinect was moved while it was levelled; the board's mounting angles are used"};
    }
  }
  const auto attitude = attitude_of(mean, calibration);
  if (!attitude) {
    return Levelled{std::nullopt, "the Kinect's accelerometer feels no gravity; the board's mounting angles are used"};
  }
  const double motor_deg = arrived.value().tilt_deg;
  if (arrived.value().knows_tilt && std::abs(motor_deg - attitude->elevation_deg) > options.agrees_deg) {
    return Levelled{
        std::nullopt,
        fmt::format("the Kinect's motor says {:.1f} degrees, its accelerometer {:.1f}; the board's mounting "
                    "angles are used (see z_forward and zero_... in the calibration file)",
                    motor_deg, attitude->elevation_deg)};
  }
  return Levelled{attitude, fmt::format("the Kinect was levelled: elevation {:.1f} degrees, roll {:.1f}",
                                        attitude->elevation_deg, attitude->roll_deg)};
}

}  // namespace g3d::hal::kinect
