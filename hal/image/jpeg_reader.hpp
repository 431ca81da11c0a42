// SPDX-License-Identifier: Apache-2.0
// JPEG colour images from outside as 8-bit RGB. libjpeg allocates its rows from the heap for each image. One thread at
// a time per reader.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "hal/image/image_size.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

class JpegReader {
 public:
  JpegReader();
  ~JpegReader();
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;

  /// What the header announces; at most kMaxImageSide_px on each side. `name` is for the error's text.
  Result<ImageSize> size(std::span<const std::uint8_t> file, std::string_view name);
  /// Grey or colour, baseline or progressive. `rgb` has 3 * expected.pixel_count() elements; after an error they are
  /// unspecified. Errors: truncated (also where libjpeg would fill in grey), malformed, unsupported, too_large, and
  /// out_of_range for another size than `expected`.
  Result<void> decode_rgb(std::span<const std::uint8_t> file, std::string_view name, ImageSize expected,
                          std::span<std::uint8_t> rgb);

 private:
  struct Decoder;
  std::unique_ptr<Decoder> decoder_;
};

}  // namespace g3d::hal
