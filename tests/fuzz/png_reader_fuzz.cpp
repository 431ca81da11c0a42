// SPDX-License-Identifier: Apache-2.0
// A PNG is decoded as depth and as colour, at the size it announces and at another; once as it is, and once with its
// checksums set right, since hardly a changed byte would get past them.
#include <zlib.h>

#include <vector>

#include "hal/image/png_reader.hpp"
#include "hal/messages.hpp"

namespace {

using namespace g3d::hal;

std::uint32_t be32(const std::uint8_t* at) {
  return static_cast<std::uint32_t>(at[0]) << 24 | static_cast<std::uint32_t>(at[1]) << 16 |
         static_cast<std::uint32_t>(at[2]) << 8 | at[3];
}

// Chunk: length, type, data, CRC of type and data.
void repair_checksums(std::vector<std::uint8_t>& file) {
  for (std::size_t at = 8; at + 12 <= file.size();) {
    const std::size_t length_bytes = be32(&file[at]);
    if (length_bytes > file.size() - at - 12) return;
    const auto crc = static_cast<std::uint32_t>(crc32(0, &file[at + 4], static_cast<uInt>(length_bytes + 4)));
    at += 8 + length_bytes;
    for (int shift = 24; shift >= 0; shift -= 8) file[at++] = static_cast<std::uint8_t>(crc >> shift);
  }
}

void decode(PngReader& reader, std::span<const std::uint8_t> file) {
  // The images end where the buffers end, so that a write beyond them is seen; and nothing is allocated each time.
  constexpr std::size_t kMaxPixels = std::size_t{kMaxImageSide_px} * kMaxImageSide_px;
  static std::vector<std::uint16_t> depth(kMaxPixels);
  static std::vector<std::uint8_t> rgb(3 * kMaxPixels);
  const Result<ImageSize> announced = reader.size(file, "fuzz.png");
  for (const ImageSize size : {announced.ok() ? announced.value() : ImageSize{8, 8}, ImageSize{16, 4}}) {
    (void)reader.decode_depth(file, "fuzz.png", size, std::span(depth).last(size.pixel_count())).ok();
    (void)reader.decode_rgb(file, "fuzz.png", size, std::span(rgb).last(3 * size.pixel_count())).ok();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  static PngReader reader;
  std::vector<std::uint8_t> file(data, data + size_bytes);
  decode(reader, file);
  repair_checksums(file);
  decode(reader, file);
  return 0;
}
