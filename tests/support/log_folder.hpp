// SPDX-License-Identifier: Apache-2.0
// Writes small recordings in the TUM RGB-D layout, and spoils them on purpose.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace g3d::test {

struct LogSpec {
  int frames = 12;
  int width_px = 64;
  int height_px = 48;
  double period_s = 1.0 / 30.0;
  bool with_colour = true;
};

/// Stamp of frame i as the lists write it.
[[nodiscard]] std::string log_stamp(const LogSpec& spec, int frame);
/// Path of the depth image of frame i.
[[nodiscard]] std::string log_depth_path(const std::string& folder, int frame);

/// A camera that looks along +x at a bumpy coloured wall 2 m away while it moves left 1 cm per frame. Writes depth/,
/// rgb/, depth.txt, rgb.txt, groundtruth.txt (one pose before the first frame and one after the last) and camera.txt.
void write_log(const std::string& folder, const LogSpec& spec);

/// Replaces line `frame` (0 = first after the comment) of one of its text files.
void replace_log_line(const std::string& path, int frame, const std::string& line);

}  // namespace g3d::test
