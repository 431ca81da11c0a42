// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/level_codec.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

std::array<ByteSpan, kLevelStreams> views(const LevelStreams& streams) {
  std::array<ByteSpan, kLevelStreams> spans;
  std::copy(streams.begin(), streams.end(), spans.begin());
  return spans;
}

LevelPlane random_plane(tests::Random& random) {
  LevelPlane plane;
  for (std::uint8_t& level : plane) level = static_cast<std::uint8_t>(random.below(33));
  return plane;
}

LowerPlanes unknown_below() {
  const LevelPlane* unknown = &constant_plane(kUnknownLevel);
  return {unknown, unknown, unknown};
}

}  // namespace

TEST_CASE("Random planes between random neighbours come back") {
  tests::Random random(91);
  LevelStreams streams;
  std::vector<std::array<LevelPlane, 4>> all;
  for (int i = 0; i < 50; ++i) {
    all.push_back({random_plane(random), random_plane(random), random_plane(random), random_plane(random)});
    encode_levels(all.back()[0], {&all.back()[1], &all.back()[2], &all.back()[3]}, streams);
  }
  LevelDecoder decoder(views(streams));
  for (const auto& planes : all) {
    LevelPlane out;
    REQUIRE(decoder.decode({&planes[1], &planes[2], &planes[3]}, out));
    REQUIRE(out == planes[0]);
  }
  CHECK(decoder.at_end());
}

TEST_CASE("What the neighbours foretell costs only zeros") {
  LevelStreams streams;
  LevelPlane floor;  // unknown below, a surface, free above: the same in the neighbours at -x and -y
  for (std::size_t i = 0; i < floor.size(); ++i) {
    const int z = decode(i).z;
    floor[i] = static_cast<std::uint8_t>(z < 3 ? 16 : z == 3 ? 32 : 0);
  }
  encode_levels(floor, {&floor, &floor, &constant_plane(16)}, streams);
  std::size_t symbols = 0;
  for (const Bytes& stream : streams) {
    symbols += stream.size();
    CHECK(std::all_of(stream.begin(), stream.end(), [](std::uint8_t residual) { return residual == 0; }));
  }
  CHECK(symbols == 512);
}

TEST_CASE("Streams that end early or hold what no level is are refused") {
  tests::Random random(92);
  LevelStreams streams;
  encode_levels(random_plane(random), unknown_below(), streams);
  LevelPlane out;
  const auto longest =
      static_cast<std::size_t>(std::max_element(streams.begin(), streams.end(),
                                                [](const Bytes& a, const Bytes& b) { return a.size() < b.size(); }) -
                               streams.begin());
  LevelStreams cut = streams;
  cut[longest].pop_back();
  CHECK_FALSE(LevelDecoder(views(cut)).decode(unknown_below(), out));
  LevelStreams wrong = streams;
  wrong[longest][wrong[longest].size() / 2] = 33;
  CHECK_FALSE(LevelDecoder(views(wrong)).decode(unknown_below(), out));
  LevelStreams longer = streams;
  longer[longest].push_back(0);
  LevelDecoder decoder(views(longer));
  CHECK(decoder.decode(unknown_below(), out));
  CHECK_FALSE(decoder.at_end());
}
