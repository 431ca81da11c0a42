// SPDX-License-Identifier: Apache-2.0
// A sensor that OpenNI2 has a driver for: a real Kinect 360 through libfreenect, or the virtual one.
#pragma once

#include <memory>
#include <string>

#include "hal/clock.hpp"
#include "hal/kinect/openni/driver_table.hpp"
#include "hal/kinect/sensor_link.hpp"

namespace g3d::hal::kinect::openni {

struct OpenNiOptions {
  Driver driver = Driver::freenect;
  /// What is seen is recorded into this .oni file, depth without loss and colour as JPEG; empty: not. What is seen
  /// after a sensor was lost and found goes into another file: eyes.oni, eyes-2.oni, ...
  std::string record_path;
};

/// `clock` stamps what arrives, and outlives the link.
[[nodiscard]] std::unique_ptr<SensorLink> make_openni_link(const Clock& clock, const OpenNiOptions& options);

/// "a/eyes.oni", 3 -> "a/eyes-3.oni"; 1 -> as it is.
[[nodiscard]] std::string numbered_path(const std::string& path, std::uint64_t number);

}  // namespace g3d::hal::kinect::openni
