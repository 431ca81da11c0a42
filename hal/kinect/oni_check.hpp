// SPDX-License-Identifier: Apache-2.0
// Checks an .oni file before OpenNI2 plays it: its player believes sizes, offsets, names and codes as they stand, so
// each is looked at here first, in the order in which it would be played. What is refused is refused as a whole.
//
// The format: a header (magic "NI10", version 1.0.0.5 to 1.0.1.0, last stamp, highest node), then records: magic
// "NIR\0", type, node, size of the fields with this head, size of what follows the fields, place of the record that it
// replaces. Nodes (a device, depth, image) are added, described by properties, declared ready, then their images come.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "hal/result.hpp"

namespace g3d::hal::kinect {

struct OniStreamInfo {
  int width_px = 0;
  int height_px = 0;
  std::size_t frames = 0;  ///< that are in the file
  bool is_mirrored = false;
  double horizontal_fov_rad = 0.0;  ///< 0: not said
};

struct OniFile {
  OniStreamInfo depth;   ///< millimetres
  OniStreamInfo colour;  ///< RGB; of the size of the depth images
  [[nodiscard]] bool has_colour() const { return colour.frames > 0; }
};

/// Errors name the byte: truncated (ends before what it announces, as recordings do whose program was killed),
/// malformed, unsupported (other versions, codes and formats; cropped), out_of_range.
[[nodiscard]] Result<OniFile> check_oni(std::span<const std::uint8_t> file, std::string_view name);
/// The same of a file, without reading it into memory. Also: not_found, no_permission, io_error.
[[nodiscard]] Result<OniFile> check_oni_file(const std::string& path);

}  // namespace g3d::hal::kinect
