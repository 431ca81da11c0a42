// SPDX-License-Identifier: Apache-2.0
#include "net/block_levels.hpp"

#include <catch2/catch.hpp>
#include <memory>

#include "net/range_coder.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::net;

namespace {

/// Bytes that the levels take; 0 if they do not come back.
template <typename LevelAt>
std::size_t bytes_of_levels(const LevelAt& level_at, Part part) {
  static const auto models = std::make_unique<BlockModels>();
  const PlaceRange places = places_of(part);
  LevelGrid grid;
  grid.fill(kNoLevel);
  for (std::size_t i = places.begin; i < places.end; ++i) {
    grid[kGridOrder.grid[i]] = static_cast<std::uint8_t>(level_at(mapper::decode(kGridOrder.block[i])));
  }
  std::array<std::uint8_t, 2048> out;
  RangeEncoder encoder;
  encoder.open(out, 1);
  models->restart();
  LevelCoding(encoder, *models).run(grid, places);
  const std::size_t size = encoder.finish();
  LevelGrid back;
  back.fill(kNoLevel);
  RangeDecoder decoder;
  decoder.open(mapper::ByteSpan(out).first(size), 1);
  models->restart();
  LevelCoding(decoder, *models).run(back, places);
  return back == grid && decoder.at_end() ? size : 0;
}

}  // namespace

TEST_CASE("Random levels come back, in wholes and halves") {
  tests::Random random(6);
  for (int i = 0; i < 100; ++i) {
    const std::uint32_t kinds = 1 + random.below(33);
    for (const Part part : {Part::whole, Part::low_half, Part::high_half}) {
      REQUIRE(bytes_of_levels([&](auto) { return random.below(kinds) * 32 / std::max(1U, kinds - 1); }, part) > 0);
    }
  }
}

TEST_CASE("Every level may stand next to every other", "[slow]") {
  for (int a = 0; a <= 32; ++a) {
    for (int b = 0; b <= 32; ++b) {
      REQUIRE(bytes_of_levels([&](auto v) { return (v.x ^ v.y ^ v.z) % 2 == 0 ? a : b; }, Part::whole) > 0);
    }
  }
}

TEST_CASE("What a map looks like takes few bytes") {
  const auto floor = [](auto v) { return v.z < 3 ? 16 : v.z == 3 ? 32 : 0; };
  CHECK(bytes_of_levels(floor, Part::whole) < 12);
  const auto seen_once = [](auto v) { return v.x < 5 ? 14 : v.x == 5 ? 20 : 16; };
  CHECK(bytes_of_levels(seen_once, Part::whole) < 16);
  const auto edge_of_view = [](auto v) { return std::max(0, 14 - 2 * std::max(0, v.x + v.y - 6)); };
  CHECK(bytes_of_levels(edge_of_view, Part::whole) < 60);
}
