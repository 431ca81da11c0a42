// SPDX-License-Identifier: Apache-2.0
// A recording of OpenNI's in place of a camera, played by OpenNI2 frame by frame as they are asked for. The file is
// checked before OpenNI2 sees it (hal/kinect/oni_check.hpp). Stamps are the recording's own, from its beginning.
#pragma once

#include <memory>
#include <string>

#include "hal/depth_camera.hpp"
#include "hal/kinect/calibration.hpp"
#include "hal/kinect/oni_check.hpp"
#include "hal/result.hpp"

namespace g3d::hal::kinect::openni {

struct OniCameraOptions {
  Calibration calibration;
  bool has_calibration = false;  ///< else the camera is as the file says, and depth as it was recorded
  bool keeps_mirrored = false;   ///< mirrored recordings are turned round, unless one wants them as they are
};

/// Errors: those of check_oni, not_found, no_capacity (see Session), io_error.
[[nodiscard]] Result<std::unique_ptr<DepthCamera>> open_oni_camera(const std::string& path,
                                                                   const OniCameraOptions& options);

}  // namespace g3d::hal::kinect::openni
