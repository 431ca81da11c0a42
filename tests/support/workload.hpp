// SPDX-License-Identifier: Apache-2.0
// Frames with poses in memory, so that benches time mapping and nothing else: the simulated drive through the furnished
// room that the figures are quoted on, or a recorded folder.
#pragma once

#include <string>
#include <vector>

#include "hal/messages.hpp"
#include "hal/result.hpp"

namespace g3d::test {

struct PosedImage {
  hal::Frame frame;
  hal::Pose T_world_camera;
};

struct Workload {
  std::string name;
  hal::CameraModel camera;
  std::vector<PosedImage> frames;
};

/// `count` frames of a built-in drive (noise on, seed 1), one every `step_s`, from `start_s` on; width 640, 320 or 160.
[[nodiscard]] Workload simulated_drive(const std::string& builtin, int count, double step_s, double start_s = 0.0,
                                       int width_px = 640, bool noise = true);
/// The first `count` usable frames of a TUM folder; empty frames if it cannot be read.
[[nodiscard]] Workload recorded(const std::string& folder, std::size_t count);

}  // namespace g3d::test
