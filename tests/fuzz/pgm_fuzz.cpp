// SPDX-License-Identifier: Apache-2.0
// What is read as a PGM is written and read again without a difference.
#include <cstdlib>

#include "hal/image/pgm.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  using namespace g3d::hal;
  const Result<GreyImage> image = parse_pgm({data, size_bytes}, "fuzz.pgm");
  if (!image) return 0;
  const Result<std::vector<std::uint8_t>> file = encode_pgm(image.value(), "again");
  if (!file) std::abort();
  const Result<GreyImage> again = parse_pgm(file.value(), "again.pgm");
  if (!again || again.value().size != image.value().size || again.value().max_value != image.value().max_value ||
      again.value().pixels != image.value().pixels) {
    std::abort();
  }
  return 0;
}
