// SPDX-License-Identifier: Apache-2.0
// Written files are checked by the reader, whose own tests use files made by libpng alone.
#include "hal/image/png_writer.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "hal/image/file_bytes.hpp"
#include "hal/image/png_reader.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::hal;
using g3d::test::TempFolder;

TEST_CASE("Depth and colour survive the way through a file") {
  const TempFolder folder;
  const ImageSize size{37, 21};
  std::mt19937 rng(5);
  std::vector<std::uint16_t> depth(size.pixel_count());
  std::vector<std::uint8_t> rgb(3 * size.pixel_count());
  for (auto& v : depth) v = static_cast<std::uint16_t>(rng());
  for (auto& v : rgb) v = static_cast<std::uint8_t>(rng());
  depth[0] = 0x0102;
  REQUIRE(write_png_depth(folder / "d.png", size, depth).ok());
  REQUIRE(write_png_rgb(folder / "c.png", size, rgb).ok());
  CHECK(folder.listing() == "c.png\nd.png\n");

  PngReader reader;
  std::vector<std::uint16_t> depth_back(depth.size());
  std::vector<std::uint8_t> rgb_back(rgb.size());
  REQUIRE(reader.decode_depth(read_file(folder / "d.png", 1 << 20).value(), "d", size, depth_back).ok());
  REQUIRE(reader.decode_rgb(read_file(folder / "c.png", 1 << 20).value(), "c", size, rgb_back).ok());
  CHECK(depth_back == depth);
  CHECK(rgb_back == rgb);
}

TEST_CASE("Impossible sizes and buffers are refused") {
  const std::vector<std::uint8_t> rgb(12);
  CHECK(encode_png_rgb({2, 2}, rgb).ok());
  CHECK(encode_png_rgb({2, 3}, rgb).error().reason == Reason::bad_usage);
  CHECK(encode_png_rgb({0, 2}, {}).error().reason == Reason::bad_usage);
  CHECK(encode_png_rgb({-1, 2}, {}).error().reason == Reason::bad_usage);
  CHECK(encode_png_rgb({kMaxPngSide_px + 1, 2}, rgb).error().reason == Reason::bad_usage);
  CHECK(write_png_rgb("/nowhere/at/all.png", {2, 2}, rgb).error().reason == Reason::not_found);
}
