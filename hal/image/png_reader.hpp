// SPDX-License-Identifier: Apache-2.0
// PNG files from outside: 16-bit grey depth, and colour of any PNG kind as 8-bit RGB. Works inside a fixed arena, so
// that decoding allocates nothing and a lying file cannot ask for more. One thread at a time per reader.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "hal/image/image_size.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

class PngReader {
 public:
  PngReader();
  ~PngReader();
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  /// What the header announces; at most kMaxImageSide_px on each side. `name` is for the error's text.
  Result<ImageSize> size(std::span<const std::uint8_t> file, std::string_view name);
  /// 16-bit grey only, host byte order. Errors: truncated, malformed, unsupported (not 16-bit grey), too_large, and
  /// out_of_range for another size than `expected`. `depth` has expected.pixel_count() elements; after an error they
  /// are unspecified.
  Result<void> decode_depth(std::span<const std::uint8_t> file, std::string_view name, ImageSize expected,
                            std::span<std::uint16_t> depth);
  /// Grey, palette, RGB, with or without alpha (which is ignored), any depth. `rgb` has 3 * expected.pixel_count()
  /// elements. Errors as above.
  Result<void> decode_rgb(std::span<const std::uint8_t> file, std::string_view name, ImageSize expected,
                          std::span<std::uint8_t> rgb);

 private:
  struct Decoder;
  std::unique_ptr<Decoder> decoder_;
};

}  // namespace g3d::hal
