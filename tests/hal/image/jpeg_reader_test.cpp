// SPDX-License-Identifier: Apache-2.0
// Files are made here with libjpeg itself, then broken in every way a disk or an enemy can.
#include "hal/image/jpeg_reader.hpp"

#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <vector>
// clang-format off
#include <jpeglib.h>
// clang-format on

using namespace g3d::hal;

namespace {

using Bytes = std::vector<std::uint8_t>;
const ImageSize kSize{48, 32};

// A smooth gradient, which JPEG keeps within a few levels.
Bytes make_jpeg(int components, bool progressive, J_COLOR_SPACE space) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* out = nullptr;
  unsigned long out_bytes = 0;
  jpeg_mem_dest(&jpeg, &out, &out_bytes);
  jpeg.image_width = static_cast<JDIMENSION>(kSize.width_px);
  jpeg.image_height = static_cast<JDIMENSION>(kSize.height_px);
  jpeg.input_components = components;
  jpeg.in_color_space = space;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 95, TRUE);
  if (progressive) jpeg_simple_progression(&jpeg);
  jpeg_start_compress(&jpeg, TRUE);
  for (int y = 0; y < kSize.height_px; ++y) {
    Bytes row;
    for (int x = 0; x < kSize.width_px; ++x) {
      for (int c = 0; c < components; ++c) row.push_back(static_cast<std::uint8_t>(40 * c + 2 * x + y));
    }
    JSAMPROW pointer = row.data();
    jpeg_write_scanlines(&jpeg, &pointer, 1);
  }
  jpeg_finish_compress(&jpeg);
  Bytes file(out, out + out_bytes);
  jpeg_destroy_compress(&jpeg);
  std::free(out);
  return file;
}

Bytes colour_jpeg(bool progressive = false) { return make_jpeg(3, progressive, JCS_RGB); }

Reason error_of(const Bytes& file, ImageSize expected = kSize) {
  JpegReader reader;
  Bytes rgb(3 * expected.pixel_count());
  const Result<void> decoded = reader.decode_rgb(file, "c.jpg", expected, rgb);
  REQUIRE_FALSE(decoded.ok());
  CHECK(decoded.error().text.find("c.jpg: ") == 0);
  return decoded.error().reason;
}

}  // namespace

TEST_CASE("Colour, progressive and grey JPEGs become RGB") {
  JpegReader reader;
  Bytes rgb(3 * kSize.pixel_count());
  for (const bool progressive : {false, true}) {
    const Bytes file = colour_jpeg(progressive);
    CHECK(reader.size(file, "c.jpg").value() == kSize);
    REQUIRE(reader.decode_rgb(file, "c.jpg", kSize, rgb).ok());
    int worst = 0;
    for (int y = 0; y < kSize.height_px; ++y) {
      for (int x = 0; x < kSize.width_px; ++x) {
        for (int c = 0; c < 3; ++c) {
          const int got = rgb[static_cast<std::size_t>(3 * (y * kSize.width_px + x) + c)];
          worst = std::max(worst, std::abs(got - (40 * c + 2 * x + y)));
        }
      }
    }
    CHECK(worst <= 8);
  }
  REQUIRE(reader.decode_rgb(make_jpeg(1, false, JCS_GRAYSCALE), "g.jpg", kSize, rgb).ok());
  CHECK(std::abs(rgb[3 * 10] - 20) <= 4);
  CHECK(rgb[3 * 10] == rgb[3 * 10 + 1]);
  CHECK(rgb[3 * 10] == rgb[3 * 10 + 2]);
}

TEST_CASE("A JPEG cut anywhere is refused, not filled with grey") {
  for (const bool progressive : {false, true}) {
    const Bytes whole = colour_jpeg(progressive);
    JpegReader reader;
    Bytes rgb(3 * kSize.pixel_count());
    for (std::size_t n = 0; n + 2 < whole.size(); ++n) {
      INFO(n);
      REQUIRE_FALSE(reader.decode_rgb(std::span(whole).first(n), "c.jpg", kSize, rgb).ok());
    }
    CHECK(error_of(Bytes(whole.begin(), whole.end() - 10)) == Reason::truncated);
    CHECK(reader.decode_rgb(whole, "c.jpg", kSize, rgb).ok());
  }
}

TEST_CASE("A byte changed anywhere in a JPEG gives an error or an image, never more") {
  const Bytes whole = colour_jpeg(true);
  JpegReader reader;
  Bytes rgb(3 * kSize.pixel_count());
  std::size_t refused = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    Bytes broken = whole;
    broken[i] ^= 0x55;
    if (!reader.decode_rgb(broken, "c.jpg", kSize, rgb).ok()) ++refused;
  }
  CHECK(refused > 100);
}

TEST_CASE("Other sizes, other kinds and lies are told apart") {
  const Bytes whole = colour_jpeg();
  CHECK(error_of(whole, {48, 31}) == Reason::out_of_range);
  CHECK(error_of({}) == Reason::truncated);
  CHECK(error_of(Bytes(100, 1)) == Reason::malformed);
  CHECK(error_of(make_jpeg(4, false, JCS_CMYK)) == Reason::unsupported);

  // Start of frame (baseline): FF C0, length, precision, height, width.
  Bytes lying = whole;
  std::size_t at = 0;
  while (lying[at] != 0xFF || lying[at + 1] != 0xC0) ++at;
  lying[at + 5] = 0xFF;
  lying[at + 7] = 0xFF;
  CHECK(error_of(lying) == Reason::too_large);
  CHECK(JpegReader().size(lying, "c.jpg").error().reason == Reason::too_large);
}

TEST_CASE("A progressive file with hundreds of scans is stopped") {
  Bytes file = colour_jpeg(true);
  // Repeat the last scan (from its start-of-scan marker to the end-of-image marker) many times.
  std::size_t last_scan = 0;
  for (std::size_t i = 0; i + 1 < file.size(); ++i) {
    if (file[i] == 0xFF && file[i + 1] == 0xDA) last_scan = i;
  }
  const Bytes scan(file.begin() + static_cast<std::ptrdiff_t>(last_scan), file.end() - 2);
  file.resize(file.size() - 2);
  for (int i = 0; i < 300; ++i) file.insert(file.end(), scan.begin(), scan.end());
  file.insert(file.end(), {0xFF, 0xD9});
  CHECK(error_of(file) == Reason::too_large);
}
