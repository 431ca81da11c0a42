// SPDX-License-Identifier: Apache-2.0
// Pictures and recorded depth as PNG.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hal/image/image_size.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

/// `rgb`: 3 * size.pixel_count() bytes, row-major. Fails only for a size outside of 1..kMaxPngSide_px or a buffer of
/// another length (bad_usage), or without memory (no_capacity).
inline constexpr int kMaxPngSide_px = 16384;
Result<std::vector<std::uint8_t>> encode_png_rgb(ImageSize size, std::span<const std::uint8_t> rgb);
/// 16-bit grey; `depth`: size.pixel_count() values in host byte order.
Result<std::vector<std::uint8_t>> encode_png_depth(ImageSize size, std::span<const std::uint16_t> depth);

/// The same into a file, by temp and rename.
Result<void> write_png_rgb(const std::string& path, ImageSize size, std::span<const std::uint8_t> rgb);
Result<void> write_png_depth(const std::string& path, ImageSize size, std::span<const std::uint16_t> depth);

}  // namespace g3d::hal
