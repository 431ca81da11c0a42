// SPDX-License-Identifier: Apache-2.0
// What of hal/kinect stands on OpenNI2 and libusb, as everybody else asks for it: a program may have been built without
// them (see scripts/static_libs), and then these say so.
#pragma once

#include <memory>
#include <string>

#include "hal/clock.hpp"
#include "hal/depth_camera.hpp"
#include "hal/kinect/calibration.hpp"
#include "hal/kinect/sensor_link.hpp"
#include "hal/result.hpp"

namespace g3d::hal::kinect {

[[nodiscard]] bool is_openni_built_in();

/// A Kinect 360 by libfreenect. `record_path`: an .oni file, or empty. `clock` outlives it.
[[nodiscard]] Result<std::unique_ptr<SensorLink>> make_freenect_link(const Clock& clock,
                                                                     const std::string& record_path);
/// A device that shows what another camera sees (640 x 480, millimetres), through all of OpenNI2; `shown` and `clock`
/// outlive it.
[[nodiscard]] Result<std::unique_ptr<SensorLink>> make_virtual_link(Clock& clock, const std::string& record_path,
                                                                    DepthCamera& shown, double rate_hz);
/// A recording. `calibration`: nullptr, or what is known of the Kinect that it was made with.
[[nodiscard]] Result<std::unique_ptr<DepthCamera>> open_recording(const std::string& path,
                                                                  const Calibration* calibration);

}  // namespace g3d::hal::kinect
