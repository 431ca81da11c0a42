// SPDX-License-Identifier: Apache-2.0
// The small text files of a TUM RGB-D folder, parsed from memory. All of it is hostile: errors name file and line.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/messages.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

struct ImageEntry {
  TimeNs stamp_ns = 0;
  std::string file;  ///< relative to the folder, never leaving it
};

/// TUM's defaults for a folder without camera.txt.
[[nodiscard]] CameraModel tum_default_camera();

/// camera.txt: one line `fx fy cx cy depth_units_per_metre width height`.
Result<CameraModel> parse_camera(std::string_view text, std::string_view name);

/// depth.txt and rgb.txt: lines `stamp file`, in the order of the file. A name may contain blanks, but must be relative
/// and without `..`.
Result<std::vector<ImageEntry>> parse_image_list(std::string_view text, std::string_view name);

/// Index of the entry nearest in time, the earlier of two equally near ones; nothing if all are further than
/// `max_distance_ns`. `sorted` by stamp.
[[nodiscard]] std::optional<std::size_t> nearest_entry(std::span<const ImageEntry> sorted, TimeNs stamp_ns,
                                                       TimeNs max_distance_ns);

}  // namespace g3d::hal
