// SPDX-License-Identifier: Apache-2.0
// Width and height of an image, and the errors that every image reader shares.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <string_view>

#include "hal/result.hpp"

namespace g3d::hal {

struct ImageSize {
  int width_px = 0;
  int height_px = 0;

  [[nodiscard]] std::size_t pixel_count() const {
    return static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  }
  bool operator==(const ImageSize&) const = default;
};

/// No file of an acceptable image is larger (2048 x 2048 pixels of 8 bytes, twice).
inline constexpr std::size_t kMaxImageFile_bytes = std::size_t{64} << 20;

/// Reason::out_of_range is what image readers use for this alone, so that callers can count wrong sizes apart.
[[nodiscard]] inline Error wrong_size_error(std::string_view name, ImageSize got, ImageSize expected) {
  return {Reason::out_of_range, fmt::format("{}: is {}x{} pixels, {}x{} are expected; check the size in camera.txt",
                                            name, got.width_px, got.height_px, expected.width_px, expected.height_px)};
}

}  // namespace g3d::hal
