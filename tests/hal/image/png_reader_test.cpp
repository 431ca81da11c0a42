// SPDX-License-Identifier: Apache-2.0
// Files of every PNG kind are made here with libpng itself, then broken in every way a disk or an enemy can.
#include "hal/image/png_reader.hpp"

#include <png.h>
#include <zlib.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <vector>

#include "hal/messages.hpp"

using namespace g3d::hal;

namespace {

using Bytes = std::vector<std::uint8_t>;

struct Kind {
  int bit_depth = 8;
  int colour_type = PNG_COLOR_TYPE_RGB;
  int interlace = PNG_INTERLACE_NONE;
};

// Rows as PNG wants them: big-endian samples, packed.
Bytes make_png(ImageSize size, Kind kind, const std::vector<Bytes>& rows) {
  Bytes out;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &out,
      [](png_structp p, png_bytep data, std::size_t n) {
        auto& to = *static_cast<Bytes*>(png_get_io_ptr(p));
        to.insert(to.end(), data, data + n);
      },
      [](png_structp) {});
  png_set_IHDR(png, info, static_cast<png_uint_32>(size.width_px), static_cast<png_uint_32>(size.height_px),
               kind.bit_depth, kind.colour_type, kind.interlace, 0, 0);
  if (kind.colour_type == PNG_COLOR_TYPE_PALETTE) {
    const png_color palette[4] = {{1, 2, 3}, {10, 20, 30}, {100, 0, 50}, {255, 254, 253}};
    png_set_PLTE(png, info, palette, 4);
    const png_byte alpha[2] = {0, 128};
    png_set_tRNS(png, info, alpha, 2, nullptr);
  }
  std::vector<png_text> texts(1);
  char key[] = "Comment";
  std::string text(1000, 'x');
  texts[0].compression = PNG_TEXT_COMPRESSION_zTXt;
  texts[0].key = key;
  texts[0].text = text.data();
  texts[0].text_length = text.size();
  png_set_text(png, info, texts.data(), 1);
  png_write_info(png, info);
  std::vector<png_bytep> pointers;
  for (const Bytes& row : rows) pointers.push_back(const_cast<png_bytep>(row.data()));
  png_write_image(png, pointers.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return out;
}

Bytes depth_png(ImageSize size, int interlace = PNG_INTERLACE_NONE) {
  std::vector<Bytes> rows;
  for (int y = 0; y < size.height_px; ++y) {
    Bytes row;
    for (int x = 0; x < size.width_px; ++x) {
      const int v = y * size.width_px + x + 250;
      row.push_back(static_cast<std::uint8_t>(v >> 8));
      row.push_back(static_cast<std::uint8_t>(v));
    }
    rows.push_back(row);
  }
  return make_png(size, {16, PNG_COLOR_TYPE_GRAY, interlace}, rows);
}

Bytes rgb_of(const Bytes& file, ImageSize size) {
  PngReader reader;
  Bytes rgb(3 * size.pixel_count());
  const Result<void> decoded = reader.decode_rgb(file, "c.png", size, rgb);
  INFO((decoded.ok() ? "" : decoded.error().text));
  REQUIRE(decoded.ok());
  return rgb;
}

void set_be32(Bytes& bytes, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
}

// Lies in the header with a right checksum.
Bytes with_size(Bytes file, std::uint32_t width_px, std::uint32_t height_px) {
  set_be32(file, 16, width_px);
  set_be32(file, 20, height_px);
  set_be32(file, 29, static_cast<std::uint32_t>(crc32(0, file.data() + 12, 17)));
  return file;
}

Reason depth_error(const Bytes& file, ImageSize expected = {20, 10}) {
  PngReader reader;
  std::vector<std::uint16_t> depth(expected.pixel_count());
  const Result<void> decoded = reader.decode_depth(file, "d.png", expected, depth);
  REQUIRE_FALSE(decoded.ok());
  CHECK(decoded.error().text.find("d.png: ") == 0);
  return decoded.error().reason;
}

}  // namespace

TEST_CASE("16-bit depth comes in host byte order, interlaced or not") {
  const ImageSize size{20, 10};
  PngReader reader;
  for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7}) {
    std::vector<std::uint16_t> depth(size.pixel_count());
    const Bytes file = depth_png(size, interlace);
    CHECK(reader.size(file, "d.png").value() == size);
    REQUIRE(reader.decode_depth(file, "d.png", size, depth).ok());
    for (std::size_t i = 0; i < depth.size(); ++i) REQUIRE(depth[i] == i + 250);
  }
}

TEST_CASE("Every colour kind becomes RGB") {
  const ImageSize size{2, 1};
  CHECK(rgb_of(make_png(size, {8, PNG_COLOR_TYPE_RGB}, {{1, 2, 3, 4, 5, 6}}), size) == Bytes{1, 2, 3, 4, 5, 6});
  CHECK(rgb_of(make_png(size, {8, PNG_COLOR_TYPE_RGB_ALPHA}, {{1, 2, 3, 0, 4, 5, 6, 9}}), size) ==
        Bytes{1, 2, 3, 4, 5, 6});
  CHECK(rgb_of(make_png(size, {8, PNG_COLOR_TYPE_GRAY}, {{7, 200}}), size) == Bytes{7, 7, 7, 200, 200, 200});
  CHECK(rgb_of(make_png(size, {8, PNG_COLOR_TYPE_GRAY_ALPHA}, {{7, 0, 200, 1}}), size) ==
        Bytes{7, 7, 7, 200, 200, 200});
  CHECK(rgb_of(make_png(size, {1, PNG_COLOR_TYPE_GRAY}, {{0x40}}), size) == Bytes{0, 0, 0, 255, 255, 255});
  CHECK(rgb_of(make_png(size, {2, PNG_COLOR_TYPE_PALETTE}, {{0xB0}}), size) == Bytes{100, 0, 50, 255, 254, 253});
  CHECK(rgb_of(make_png(size, {16, PNG_COLOR_TYPE_RGB}, {{1, 0, 2, 0, 3, 0, 255, 255, 5, 0, 6, 0}}), size) ==
        Bytes{1, 2, 3, 255, 5, 6});
}

TEST_CASE("Depth must be 16-bit grey of the expected size") {
  const ImageSize size{20, 10};
  const Bytes eight_bit = make_png(size, {8, PNG_COLOR_TYPE_GRAY}, std::vector<Bytes>(10, Bytes(20)));
  CHECK(depth_error(eight_bit) == Reason::unsupported);
  CHECK(depth_error(make_png(size, {8, PNG_COLOR_TYPE_RGB}, std::vector<Bytes>(10, Bytes(60)))) == Reason::unsupported);
  CHECK(depth_error(depth_png({19, 10})) == Reason::out_of_range);
  CHECK(depth_error(depth_png({20, 11})) == Reason::out_of_range);
}

TEST_CASE("A file cut anywhere is refused") {
  const Bytes whole = depth_png({20, 10});
  PngReader reader;
  std::vector<std::uint16_t> depth(200);
  for (std::size_t n = 0; n < whole.size(); ++n) {
    INFO(n);
    REQUIRE_FALSE(reader.decode_depth(std::span(whole).first(n), "d.png", {20, 10}, depth).ok());
  }
  CHECK(depth_error(Bytes(whole.begin(), whole.end() - 20)) == Reason::truncated);
  // The same reader goes on with the next good file.
  CHECK(reader.decode_depth(whole, "d.png", {20, 10}, depth).ok());
}

TEST_CASE("A byte changed anywhere in a PNG gives an error or an image, never more") {
  const Bytes whole = depth_png({20, 10});
  PngReader reader;
  std::vector<std::uint16_t> depth(200);
  std::size_t refused = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    Bytes broken = whole;
    broken[i] ^= 0x55;
    if (!reader.decode_depth(broken, "d.png", {20, 10}, depth).ok()) ++refused;
  }
  CHECK(refused > whole.size() / 4);  // all but the ignored comment
}

TEST_CASE("A lying header costs no memory and is told by name") {
  const Bytes whole = depth_png({20, 10});
  CHECK(depth_error(with_size(whole, 2'000'000'000, 10)) == Reason::too_large);
  CHECK(depth_error(with_size(whole, 20, 2049)) == Reason::too_large);
  CHECK(depth_error(with_size(whole, 20, 11)) == Reason::out_of_range);
  CHECK_FALSE(PngReader().size(with_size(whole, 0, 10), "d.png").ok());
  CHECK(PngReader().size(with_size(whole, 3000, 10), "d.png").error().reason == Reason::too_large);
  // It announces more rows than it has.
  CHECK(depth_error(with_size(whole, 20, 12), {20, 12}) != Reason::out_of_range);
  CHECK(depth_error({}) == Reason::truncated);
  CHECK(depth_error(Bytes(100, 0)) == Reason::malformed);
}

TEST_CASE("The largest accepted image fits into the arena") {
  const ImageSize size{kMaxImageSide_px, 3};
  const Bytes file =
      make_png(size, {16, PNG_COLOR_TYPE_RGB_ALPHA, PNG_INTERLACE_ADAM7}, std::vector<Bytes>(3, Bytes(2048 * 8, 9)));
  const Bytes rgb = rgb_of(file, size);
  CHECK(rgb.size() == 3U * 2048 * 3);
  CHECK(rgb[5000] == 9);
}
