// SPDX-License-Identifier: Apache-2.0
// Turns the camera level at the start, and measures how it stands then: elevation of its optical axis and roll, by
// gravity. The measurement counts only where motor and accelerometer say the same, for which way the accelerometer's
// axes point was taken from documentation and not from the device that is in front of us; else the board's numbers
// stay.
#pragma once

#include <optional>
#include <string>

#include "hal/clock.hpp"
#include "hal/kinect/calibration.hpp"
#include "hal/kinect/tilt_unit.hpp"

namespace g3d::hal::kinect {

struct Attitude {
  double elevation_deg = 0.0;  ///< of the optical axis: above 0 it looks up
  double roll_deg = 0.0;       ///< above 0 the image is turned clockwise about the axis: its right side is low
};

/// From what the accelerometer feels at rest. None if that is no gravity: less than 0.9 or more than 1.1 g.
[[nodiscard]] std::optional<Attitude> attitude_of(const TiltState& state, const Calibration& calibration);

struct LevellingOptions {
  double target_deg = 0.0;             ///< elevation that the camera shall have
  TimeNs patience_ns = 8'000'000'000;  ///< for the motor to arrive
  TimeNs poll_ns = 100'000'000;
  int samples = 20;             ///< of the accelerometer, averaged
  double agrees_deg = 5.0;      ///< motor and accelerometer
  double most_unrest_g = 0.05;  ///< standard deviation: above, somebody carries the robot
};

struct Levelled {
  std::optional<Attitude> attitude;  ///< measured; none: not to be believed, see `note`
  std::string note;                  ///< for the report
};

/// Takes some seconds. Errors: those of the foot.
[[nodiscard]] Result<Levelled> level_camera(TiltUnit& foot, Clock& clock, const Calibration& calibration,
                                            const LevellingOptions& options = {});

}  // namespace g3d::hal::kinect
