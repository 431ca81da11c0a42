// SPDX-License-Identifier: Apache-2.0
// A recording from hostile hands: the file that says what its map was made of, and packed images. What is read stays
// within its limits; an image is refused, or is the one whose checksum it carries.
#include <cmath>
#include <cstdlib>
#include <vector>

#include "hal/record/packed_image.hpp"
#include "hal/replay/recording.hpp"

namespace {

using namespace g3d::hal;

void check(bool holds) {
  if (!holds) std::abort();
}

void fuzz_mapped_log(std::string_view text) {
  const auto log = parse_mapped_log(text, "mapped.txt");
  if (!log) return;
  if (log.value().footprint) {
    for (const double x : log.value().footprint->at_m) check(std::isfinite(x));
    check(log.value().footprint->radius_m > 0.0 && log.value().footprint->radius_m <= 10.0);
  }
  for (const auto& [stamp_ns, file] : log.value().masked) check(!file.empty() && file.front() != '/');
  check(log.value().hash.empty() || log.value().hash.size() == 64);
}

void fuzz_image(std::span<const std::uint8_t> file) {
  static ImageUnpacker unpacker;
  const ImageSize size{8, 6};
  std::vector<std::uint16_t> depth(size.pixel_count());
  std::vector<std::uint8_t> rgb(3 * size.pixel_count());
  const bool is_depth = unpacker.unpack_depth(file, "d", size, depth).ok();
  const bool is_colour = unpacker.unpack_rgb(file, "c", size, rgb).ok();
  check(!(is_depth && is_colour));
  static ImagePacker packer(size);
  if (is_depth) check(is_packed_image(packer.pack_depth(size, depth)));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  fuzz_mapped_log({reinterpret_cast<const char*>(data), size_bytes});
  fuzz_image({data, size_bytes});
  return 0;
}
