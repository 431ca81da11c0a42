// SPDX-License-Identifier: Apache-2.0
#include "hal/record/packed_image.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "hal/sim/seeded_random.hpp"

using namespace g3d::hal;

namespace {

constexpr ImageSize kSize{40, 30};

std::vector<std::uint16_t> smooth_depth() {
  std::vector<std::uint16_t> depth(kSize.pixel_count());
  for (std::size_t i = 0; i < depth.size(); ++i) {
    depth[i] = static_cast<std::uint16_t>(i % 7 == 0 ? 0 : 1200 + i % 40 * 3 + i / 200);
  }
  return depth;
}

std::vector<std::uint8_t> bytes_of(std::span<const std::uint8_t> file) { return {file.begin(), file.end()}; }

std::vector<std::uint8_t> packed_depth() {
  ImagePacker packer(kSize);
  return bytes_of(packer.pack_depth(kSize, smooth_depth()));
}

Reason refused_for(const std::vector<std::uint8_t>& file, ImageSize size = kSize) {
  ImageUnpacker unpacker;
  std::vector<std::uint16_t> depth(size.pixel_count());
  const auto got = unpacker.unpack_depth(file, "a.g3i", size, depth);
  REQUIRE_FALSE(got.ok());
  CHECK(got.error().text.find("a.g3i: ") == 0);
  return got.error().reason;
}

}  // namespace

TEST_CASE("depth and colour come back as they were, whatever they are") {
  ImagePacker packer(kSize);
  ImageUnpacker unpacker;
  SeededRandom random(5);
  for (int round = 0; round < 6; ++round) {
    std::vector<std::uint16_t> depth = smooth_depth();
    std::vector<std::uint8_t> rgb(3 * kSize.pixel_count());
    if (round > 0) {
      for (std::uint16_t& value : depth) value = static_cast<std::uint16_t>(random.bits());
      for (std::uint8_t& value : rgb) value = static_cast<std::uint8_t>(random.bits());
    }
    if (round == 5) std::fill(depth.begin(), depth.end(), std::uint16_t{0xFFFF});
    std::vector<std::uint16_t> depth_again(depth.size());
    std::vector<std::uint8_t> rgb_again(rgb.size());
    const auto depth_file = bytes_of(packer.pack_depth(kSize, depth));
    REQUIRE(is_packed_image(depth_file));
    REQUIRE(unpacker.unpack_depth(depth_file, "d", kSize, depth_again).ok());
    const auto rgb_file = bytes_of(packer.pack_rgb(kSize, rgb));
    REQUIRE(unpacker.unpack_rgb(rgb_file, "c", kSize, rgb_again).ok());
    CHECK(depth_again == depth);
    CHECK(rgb_again == rgb);
    CHECK_FALSE(unpacker.unpack_rgb(depth_file, "d", kSize, rgb_again).ok());
  }
}

TEST_CASE("what a camera sees gets a good deal smaller") { CHECK(packed_depth().size() < kSize.pixel_count()); }

TEST_CASE("a file that was cut, spoiled, or is none is refused by name") {
  const std::vector<std::uint8_t> good = packed_depth();
  CHECK(refused_for({}) == Reason::malformed);
  CHECK(refused_for({good.begin(), good.begin() + 20}) == Reason::truncated);
  CHECK(refused_for({good.begin(), good.end() - 1}) == Reason::truncated);
  CHECK(refused_for(good, {40, 31}) == Reason::out_of_range);
  std::vector<std::uint8_t> longer = good;
  longer.push_back(0);
  CHECK(refused_for(longer) == Reason::malformed);
  std::vector<std::uint8_t> version = good;
  version[8] = 2;
  CHECK(refused_for(version) == Reason::unsupported);
  std::vector<std::uint8_t> sum = good;
  sum[20] ^= 1;
  CHECK(refused_for(sum) == Reason::bad_checksum);
  // A few bits of a zstd frame mean nothing: whatever is taken is what was packed.
  for (std::size_t at = 24; at < good.size(); at += 3) {
    std::vector<std::uint8_t> bad = good;
    bad[at] ^= 0x10;
    ImageUnpacker unpacker;
    std::vector<std::uint16_t> depth(kSize.pixel_count());
    const auto got = unpacker.unpack_depth(bad, "a.g3i", kSize, depth);
    if (got.ok()) {
      CHECK(depth == smooth_depth());
    } else {
      CHECK((got.error().reason == Reason::malformed || got.error().reason == Reason::bad_checksum));
    }
  }
}
