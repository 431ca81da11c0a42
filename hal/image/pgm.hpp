// SPDX-License-Identifier: Apache-2.0
// Binary 8-bit PGM (`P5`), the picture format of map_server.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/image/image_size.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

/// Maps are larger than camera images: 800 m at 5 cm.
inline constexpr int kMaxPgmSide_px = 16384;

struct GreyImage {
  ImageSize size;
  int max_value = 255;               ///< what white is, 1..255
  std::vector<std::uint8_t> pixels;  ///< row-major, first row at the top, none above max_value
};

/// Nothing is allocated before the bytes are seen to be there. `name` is for the error's text.
Result<GreyImage> parse_pgm(std::span<const std::uint8_t> file, std::string_view name);
Result<GreyImage> read_pgm(const std::string& path);

/// `comment` goes into the header, one line; it may be empty.
Result<std::vector<std::uint8_t>> encode_pgm(const GreyImage& image, std::string_view comment);
/// By temp and rename.
Result<void> write_pgm(const std::string& path, const GreyImage& image, std::string_view comment);

}  // namespace g3d::hal
