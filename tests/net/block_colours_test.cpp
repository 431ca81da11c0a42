// SPDX-License-Identifier: Apache-2.0
#include "net/block_colours.hpp"

#include <catch2/catch.hpp>
#include <memory>

#include "net/range_coder.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::net;

namespace {

/// Bytes that the colours take; 0 if they do not come back.
std::size_t bytes_of_colours(const mapper::BlockValues& values, Part part) {
  static const auto models = std::make_unique<BlockModels>();
  static const auto tints = std::make_unique<TintGrid>();
  const PlaceRange places = places_of(part);
  std::array<std::uint8_t, 4096> out;
  RangeEncoder encoder;
  encoder.open(out, 1);
  models->restart();
  mapper::BlockValues copy = values;
  ColourCoding(encoder, *models).run(copy, *tints, places);
  const std::size_t size = encoder.finish();
  mapper::BlockValues back{};
  for (std::size_t i = places.begin; i < places.end; ++i) back[i] = mapper::level_of(values[i]);
  RangeDecoder decoder;
  decoder.open(mapper::ByteSpan(out).first(size), 1);
  models->restart();
  ColourCoding(decoder, *models).run(back, *tints, places);
  bool same = copy == values && decoder.at_end();
  for (std::size_t i = places.begin; i < places.end; ++i) same = same && back[i] == values[i];
  return same ? size : 0;
}

mapper::Rgbo coloured(std::uint32_t rgb) { return rgb << 8 | mapper::kHasColourBit | 32U; }

}  // namespace

TEST_CASE("All colours there are come back: their parts and differences at every end", "[slow]") {
  tests::Random random(7);
  for (int i = 0; i < 200; ++i) {
    mapper::BlockValues values;
    for (mapper::Rgbo& value : values) {
      const auto any = static_cast<std::uint32_t>(random.next());
      const std::uint32_t ends = (any & 1U) * 0xFFU | (any >> 1 & 1U) * 0xFF00U | (any >> 2 & 1U) * 0xFF0000U;
      value = coloured(i % 2 == 0 ? ends : any & 0xFFFFFFU);
      if (random.below(5) == 0) value = random.below(33);
    }
    for (const Part part : {Part::whole, Part::low_half, Part::high_half}) REQUIRE(bytes_of_colours(values, part) > 0);
  }
}

TEST_CASE("A surface of one colour costs little more than that colour, and noise what it is worth") {
  tests::Random random(8);
  mapper::BlockValues plain;
  mapper::BlockValues noisy;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const bool surface = mapper::decode(i).z == 4;
    plain[i] = surface ? coloured(0x8899AA) : 0;
    noisy[i] = surface ? coloured(0x8899AA + random.below(4) * 0x010101) : 0;
  }
  CHECK(bytes_of_colours(plain, Part::whole) < 24);
  CHECK(bytes_of_colours(noisy, Part::whole) < 64);
}

TEST_CASE("A block without colours costs nothing for them") {
  mapper::BlockValues values;
  values.fill(32);
  CHECK(bytes_of_colours(values, Part::whole) < 8);
  values.fill(16);
  CHECK(bytes_of_colours(values, Part::whole) <= 1);
}
