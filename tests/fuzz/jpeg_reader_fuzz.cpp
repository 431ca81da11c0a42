// SPDX-License-Identifier: Apache-2.0
// A JPEG is decoded at the size it announces and at another.
#include <vector>

#include "hal/image/jpeg_reader.hpp"
#include "hal/messages.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  using namespace g3d::hal;
  static JpegReader reader;
  // The image ends where the buffer ends, so that a write beyond it is seen; and nothing is allocated each time.
  static std::vector<std::uint8_t> rgb(3 * std::size_t{kMaxImageSide_px} * kMaxImageSide_px);
  const std::span<const std::uint8_t> file(data, size_bytes);
  const Result<ImageSize> announced = reader.size(file, "fuzz.jpg");
  for (const ImageSize size : {announced.ok() ? announced.value() : ImageSize{8, 8}, ImageSize{16, 4}}) {
    (void)reader.decode_rgb(file, "fuzz.jpg", size, std::span(rgb).last(3 * size.pixel_count())).ok();
  }
  return 0;
}
