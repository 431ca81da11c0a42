// SPDX-License-Identifier: Apache-2.0
// A recording in the TUM RGB-D layout: camera.txt, depth.txt, rgb.txt, the images they name, and a trajectory.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/messages.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

/// A colour image further away in time belongs to another moment.
inline constexpr TimeNs kMaxColourDistance_ns = 20'000'000;

struct RecordedFrame {
  TimeNs stamp_ns = 0;  ///< of the depth image
  std::string depth_path;
  std::string colour_path;  ///< empty: no colour image is near enough
};

struct TumFolder {
  CameraModel camera;
  std::vector<RecordedFrame> frames;  ///< in the order of depth.txt, which need not be that of time
  std::vector<std::string> warnings;  ///< what was missing and is replaced by a default, for the user

  /// Reads the lists, not the images. depth.txt must exist; the rest has defaults.
  static Result<TumFolder> open(const std::string& folder);
};

/// Where the poses of a recording are: trajectory.tum, else groundtruth.txt. Error if there is neither.
Result<std::string> find_trajectory(const std::string& folder);

}  // namespace g3d::hal
