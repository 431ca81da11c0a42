// SPDX-License-Identifier: Apache-2.0
#include "net/block_plain.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::net;
using mapper::BlockValues;

namespace {

using Wire = std::vector<std::uint8_t>;

Wire plain_bytes(const BlockValues& values, Part part) {
  Wire out(max_bytes_of(part));
  out.resize(pack_plain(values, places_of(part), 10'000, out));
  return out;
}

UnpackError unpacked(const Wire& bytes, Part part = Part::whole) {
  BlockValues out{};
  return unpack_plain(bytes, places_of(part), out);
}

mapper::Rgbo code_of(std::uint32_t rgb, std::uint32_t level) { return rgb << 8 | mapper::kHasColourBit | level; }

/// One block for each coding: uniform, raw, palette, runs.
BlockValues made_for(std::uint8_t first, tests::Random& random) {
  BlockValues values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto any = static_cast<std::uint32_t>(random.next());
    if (first <= mapper::kMaxLevel) values[i] = first;
    if (first == kRawByte) values[i] = code_of(any & 0xFFFFFFU, 17 + (any >> 24) % 16);
    if (first == kPaletteByte) values[i] = (any & 1U) != 0 ? code_of(0x112233, 20) : 3U;
    if (first == kRunsByte) values[i] = i < 200 ? 32U : i < 210 ? code_of(0xABCDEF, 31) : 5U;
  }
  return values;
}

}  // namespace

TEST_CASE("Each plain coding is the shortest of some block, and comes back in every part") {
  tests::Random random(11);
  for (const std::uint8_t first : {std::uint8_t{0}, std::uint8_t{32}, kRawByte, kPaletteByte, kRunsByte}) {
    const BlockValues values = made_for(first, random);
    CHECK(plain_bytes(values, Part::whole)[0] == first);
    for (const Part part : {Part::whole, Part::low_half, Part::high_half}) {
      const Wire bytes = plain_bytes(values, part);
      REQUIRE(bytes.size() <= max_bytes_of(part));
      BlockValues back{};
      REQUIRE(unpack_plain(bytes, places_of(part), back) == UnpackError::none);
      for (std::size_t i = 0; i < back.size(); ++i) {
        const bool inside = i >= places_of(part).begin && i < places_of(part).end;
        REQUIRE(back[i] == (inside ? values[i] : 0U));
      }
    }
  }
}

TEST_CASE("Palettes of 2 to 16 codes come back") {
  tests::Random random(12);
  for (std::uint32_t count = 2; count <= kMaxPalette; ++count) {
    BlockValues values;
    for (mapper::Rgbo& value : values) value = random.below(count) * 2;
    const Wire bytes = plain_bytes(values, Part::whole);
    REQUIRE(bytes[0] == kPaletteByte);
    REQUIRE(bytes.size() == 2 + count + 64 * (count <= 2 ? 1 : count <= 4 ? 2 : 4));
    BlockValues back;
    REQUIRE(unpack_plain(bytes, places_of(Part::whole), back) == UnpackError::none);
    REQUIRE(back == values);
  }
}

TEST_CASE("Nothing is written that is not shorter than asked") {
  tests::Random random(13);
  Wire out(max_bytes_of(Part::whole));
  const BlockValues runs = made_for(kRunsByte, random);
  const std::size_t needed = plain_bytes(runs, Part::whole).size();
  CHECK(pack_plain(runs, places_of(Part::whole), needed, out) == 0);
  CHECK(pack_plain(runs, places_of(Part::whole), needed + 1, out) == needed);
  CHECK(pack_plain(made_for(7, random), places_of(Part::whole), 1, out) == 0);
}

TEST_CASE("What cannot be told is left out") {
  CHECK(tellable(code_of(0x123456, 17)) == code_of(0x123456, 17));
  CHECK(tellable(code_of(0x123456, 16)) == 16);
  CHECK(tellable(0x12345600U | 32U) == 32);
  CHECK(tellable(0xFFFFFFFFU) == code_of(0xFFFFFF, 32));
  CHECK(tellable(0xFFU) == code_of(0, 32));
}

TEST_CASE("Hostile bytes are refused with the reason") {
  CHECK(unpacked({}) == UnpackError::empty);
  CHECK(unpacked({5, 0}) == UnpackError::trailing_bytes);
  CHECK(unpacked({kRawByte}) == UnpackError::truncated);
  Wire raw(513, 16);
  raw[0] = kRawByte;
  CHECK(unpacked(raw) == UnpackError::none);
  CHECK(unpacked(raw, Part::low_half) == UnpackError::trailing_bytes);
  raw[300] = 33;
  CHECK(unpacked(raw) == UnpackError::bad_level);
  raw[300] = 16 | mapper::kHasColourBit;
  CHECK(unpacked(raw) == UnpackError::bad_colour);
  raw[300] = 20 | 0x80;
  CHECK(unpacked(raw) == UnpackError::bad_colour);
  raw[300] = 20 | mapper::kHasColourBit;
  CHECK(unpacked(raw) == UnpackError::truncated);
  for (const std::uint8_t count : {0, 1, 17, 255}) {
    CHECK(unpacked({kPaletteByte, count, 1, 2, 3}) == UnpackError::bad_palette);
  }
  Wire palette(2 + 3 + 128, 0);
  palette[0] = kPaletteByte;
  palette[1] = 3;
  CHECK(unpacked(palette) == UnpackError::none);
  palette.back() = 0xC0;
  CHECK(unpacked(palette) == UnpackError::bad_palette);
  palette.back() = 0;
  palette.pop_back();
  CHECK(unpacked(palette) == UnpackError::truncated);
  CHECK(unpacked({kRunsByte, 0xFF, 0x03, 9}) == UnpackError::none);
  CHECK(unpacked({kRunsByte, 0x80, 0x04, 9}) == UnpackError::bad_run);
  CHECK(unpacked({kRunsByte, 0xFF, 0x03, 9}, Part::low_half) == UnpackError::bad_run);
  CHECK(unpacked({kRunsByte, 0xFF, 0x01, 9}, Part::high_half) == UnpackError::none);
  CHECK(unpacked({kRunsByte, 0xFE, 0x03, 9}) == UnpackError::truncated);
  CHECK(unpacked({kRunsByte, 0xFF}) == UnpackError::truncated);
  CHECK(unpacked({kRunsByte, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}) ==
        UnpackError::bad_run);
}
