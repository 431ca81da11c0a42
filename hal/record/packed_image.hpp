// SPDX-License-Identifier: Apache-2.0
// One image, packed without loss and fast enough for a robot that records while it drives: each value as its difference
// to the one before it in its row, low and high bytes of depth apart, then zstd. Little-endian:
//
//    at  bytes
//     0      8  "g3dimage"
//     8      2  version, 1
//    10      2  1: depth, 16 bits per pixel; 2: colour, R G B of 8 bits each
//    12      2  width in pixels, 1 to 2048
//    14      2  height
//    16      4  bytes of the zstd frame that follows, and ends the file
//    20      4  CRC-32 of the pixels as they were
//    24         the zstd frame
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "hal/image/image_size.hpp"
#include "hal/result.hpp"

struct ZSTD_CCtx_s;
struct ZSTD_DCtx_s;

namespace g3d::hal {

[[nodiscard]] bool is_packed_image(std::span<const std::uint8_t> file);

/// One thread at a time. Allocates at construction only.
class ImagePacker {
 public:
  explicit ImagePacker(ImageSize largest);
  ~ImagePacker();
  ImagePacker(const ImagePacker&) = delete;
  ImagePacker& operator=(const ImagePacker&) = delete;

  /// The file's bytes, valid until the next call; empty if zstd refuses. The image is at most as large as announced.
  [[nodiscard]] std::span<const std::uint8_t> pack_depth(ImageSize size, std::span<const std::uint16_t> depth);
  [[nodiscard]] std::span<const std::uint8_t> pack_rgb(ImageSize size, std::span<const std::uint8_t> rgb);

 private:
  [[nodiscard]] std::span<const std::uint8_t> pack(ImageSize size, int kind, std::span<const std::uint8_t> pixels);

  ZSTD_CCtx_s* zstd_;
  std::vector<std::uint8_t> differences_;
  std::vector<std::uint8_t> file_;
};

/// One thread at a time. Allocates for a larger image than those before, bounded by `expected`.
class ImageUnpacker {
 public:
  ImageUnpacker();
  ~ImageUnpacker();
  ImageUnpacker(const ImageUnpacker&) = delete;
  ImageUnpacker& operator=(const ImageUnpacker&) = delete;

  /// `depth` has expected.pixel_count() elements, `rgb` three times as many; after an error they are unspecified.
  /// Errors, which begin with `name`: truncated, malformed, unsupported (another kind or version), bad_checksum, and
  /// out_of_range for another size than `expected`.
  [[nodiscard]] Result<void> unpack_depth(std::span<const std::uint8_t> file, std::string_view name, ImageSize expected,
                                          std::span<std::uint16_t> depth);
  [[nodiscard]] Result<void> unpack_rgb(std::span<const std::uint8_t> file, std::string_view name, ImageSize expected,
                                        std::span<std::uint8_t> rgb);

 private:
  [[nodiscard]] Result<std::uint32_t> unpack(std::span<const std::uint8_t> file, std::string_view name, int kind,
                                             ImageSize expected);

  ZSTD_DCtx_s* zstd_;
  std::vector<std::uint8_t> differences_;
};

}  // namespace g3d::hal
