// SPDX-License-Identifier: Apache-2.0
#include "net/block_wire.hpp"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "tests/support/changed_blocks.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::net;
using mapper::BlockValues;

namespace {

using WireBytes = std::vector<std::uint8_t>;
constexpr std::array kParts{Part::whole, Part::low_half, Part::high_half};

WireBytes packed_bytes(const BlockValues& values, Part part) {
  static BlockPacker packer;
  const ByteSpan bytes = packer.pack(values, part);
  return {bytes.begin(), bytes.end()};
}

std::string hex(const WireBytes& bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

/// All parts, each alone into a block of something else.
bool comes_back_in_parts(const BlockValues& values) {
  static BlockUnpacker unpacker;
  for (const Part part : kParts) {
    const WireBytes bytes = packed_bytes(values, part);
    if (bytes.size() > max_bytes_of(part)) return false;
    BlockValues back;
    back.fill(7);
    if (unpacker.unpack(bytes, part, back) != UnpackError::none) return false;
    for (std::size_t i = 0; i < back.size(); ++i) {
      const bool inside = i >= places_of(part).begin && i < places_of(part).end;
      if (back[i] != (inside ? values[i] : 7U)) return false;
    }
  }
  return true;
}

BlockValues random_codes(tests::Random& random) {
  BlockValues values;
  const std::uint32_t from = random.below(33);  // up to 32: from any levels to saturated ones alone
  for (mapper::Rgbo& value : values) {
    const std::uint32_t rgb = static_cast<std::uint32_t>(random.next()) << 8;
    value = tellable(rgb | mapper::kHasColourBit | (from + random.below(33 - from)));
  }
  return values;
}

/// Does always what the models expect least: what it makes up is the longest that there is.
class Contrarian {
 public:
  explicit Contrarian(tests::Random& random) : random_(random) {}
  bool code(BitModel& model, bool /*unused*/) {
    const bool bit = model.probability < kEven;
    model.learn(bit);
    return bit;
  }
  bool code(Mixed mixed, bool /*unused*/) {
    const bool bit = mixed.probability() < kEven;
    mixed.learn(bit);
    return bit;
  }
  std::uint32_t code_plain(std::uint32_t /*unused*/, int count) { return random_.below(1U << count); }

 private:
  tests::Random& random_;
};

BlockValues least_expected(tests::Random& random) {
  const auto models = std::make_unique<BlockModels>();
  const auto tints = std::make_unique<TintGrid>();
  models->restart();
  LevelGrid grid;
  grid.fill(kNoLevel);
  Contrarian coder(random);
  LevelCoding(coder, *models).run(grid, places_of(Part::whole));
  BlockValues values;
  for (std::size_t i = 0; i < values.size(); ++i) values[kGridOrder.block[i]] = grid[kGridOrder.grid[i]];
  ColourCoding(coder, *models).run(values, *tints, places_of(Part::whole));
  return values;
}

const std::vector<BlockValues>& mapped_blocks() {
  static const std::vector<BlockValues> blocks =
      test::changed_blocks(test::simulated_drive("furnished_room", 24, 0.2, 3.0, 160), 0.05F, 6, 100);
  return blocks;
}

std::vector<BlockValues> blocks_of(const mapper::VoxelMap& map) {
  std::vector<BlockValues> blocks;
  for (const mapper::BlockKey key : map.sorted_keys()) map.read_stored_block(key, blocks.emplace_back());
  return blocks;
}

}  // namespace

TEST_CASE("Blocks of every make come back, whole and in halves", "[long]") {
  tests::Random random(21);
  for (const BlockValues& values : blocks_of(*tests::random_map(21, 300))) REQUIRE(comes_back_in_parts(values));
  for (int i = 0; i < 20; ++i) REQUIRE(comes_back_in_parts(random_codes(random)));
  for (const BlockValues& values : mapped_blocks()) REQUIRE(comes_back_in_parts(values));
}

TEST_CASE("Changed blocks of a map take less than a third of zstd's bytes") {
  std::size_t ours = 0;
  std::size_t zstd = 0;
  REQUIRE(mapped_blocks().size() > 200);
  for (const BlockValues& values : mapped_blocks()) {
    BlockValues codes;
    std::transform(values.begin(), values.end(), codes.begin(), mapper::published);
    std::array<std::uint8_t, 4096> out;
    zstd += ZSTD_compress(out.data(), out.size(), codes.data(), sizeof codes, 3);
    ours += packed_bytes(values, Part::whole).size();
  }
  CHECK(3 * ours < zstd);
}

// Raw is what bounds them all: not even random and least expected blocks are shortest in it (block_plain_test.cpp has
// it).
TEST_CASE("Every other coding is chosen for some block, and one level takes one byte") {
  tests::Random random(22);
  BlockValues values;
  for (std::uint8_t level = 0; level <= mapper::kMaxLevel; ++level) {
    values.fill(level);
    for (const Part part : kParts) REQUIRE(packed_bytes(values, part) == WireBytes{level});
  }
  for (mapper::Rgbo& value : values) value = random.below(2) == 0 ? 1U : 31U;
  CHECK(packed_bytes(values, Part::whole)[0] == kPaletteByte);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = i % 90 < 45 ? 27U : 5U;
  CHECK(packed_bytes(values, Part::whole)[0] == kRunsByte);
  std::size_t coded = 0;
  for (const BlockValues& mapped : mapped_blocks()) coded += packed_bytes(mapped, Part::whole)[0] >= kFirstCodedByte;
  CHECK(coded > mapped_blocks().size() / 2);
}

TEST_CASE("A half of whatever block fits, and a block is halved only beyond the limit", "[long]") {
  tests::Random random(23);
  BlockPacker packer;
  BlockUnpacker unpacker;
  std::size_t halved = 0;
  for (int i = 0; i < 50; ++i) {
    const BlockValues values = i % 5 == 0 ? least_expected(random) : random_codes(random);
    const std::size_t whole = packer.pack(values, Part::whole).size();
    const std::span<const PackedPart> parts = packer.pack_within(values);
    REQUIRE(parts.size() == (whole > kDefaultBlockLimit_bytes ? 2 : 1));
    halved += parts.size() - 1;
    BlockValues back{};
    for (const PackedPart& part : parts) {
      REQUIRE(part.bytes.size() <= kDefaultBlockLimit_bytes);
      REQUIRE(part.bytes.size() <= 1025);
      REQUIRE(unpacker.unpack(part.bytes, part.part, back) == UnpackError::none);
    }
    REQUIRE(back == values);
  }
  CHECK(halved > 10);
  const BlockValues& mapped = mapped_blocks().front();
  const std::size_t whole = packed_bytes(mapped, Part::whole).size();
  REQUIRE(packer.pack_within(mapped, whole).size() == 1);
  CHECK(packer.pack_within(mapped, whole)[0].part == Part::whole);
  CHECK(packer.pack_within(mapped, whole - 1).size() == 2);
}

TEST_CASE("A block does not depend on what was packed or unpacked before it") {
  BlockPacker used;
  for (const BlockValues& values : mapped_blocks()) {
    BlockPacker fresh;
    const ByteSpan a = used.pack(values, Part::whole);
    const ByteSpan b = fresh.pack(values, Part::whole);
    REQUIRE(std::equal(a.begin(), a.end(), b.begin(), b.end()));
    if (&values - mapped_blocks().data() > 50) break;
  }
}

TEST_CASE("Cut, prolonged and flipped bytes are refused or give a valid block, and what is refused changes nothing",
          "[long]") {
  tests::Random random(24);
  BlockUnpacker unpacker;
  std::set<UnpackError> reasons;
  BlockValues marked;
  marked.fill(9);
  const auto is_fine = [&](const WireBytes& bytes, Part part) {
    BlockValues out = marked;
    const UnpackError error = unpacker.unpack(bytes, part, out);
    reasons.insert(error);
    if (error != UnpackError::none) return out == marked;
    return std::all_of(out.begin(), out.end(), [](mapper::Rgbo value) { return value == tellable(value); });
  };
  const std::vector<BlockValues> made = blocks_of(*tests::random_map(24, 60));
  for (std::size_t i = 0; i < 150; ++i) {
    const BlockValues& values = i % 3 == 0 ? made[i % made.size()] : mapped_blocks()[i];
    const Part part = kParts[i % 2 == 0 ? 0 : 1 + i / 2 % 2];
    const WireBytes good = packed_bytes(values, part);
    for (std::size_t cut = 0; cut < good.size(); cut += 1 + good.size() / 16) {
      const WireBytes shorter(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(cut));
      REQUIRE(is_fine(shorter, part));
      BlockValues out = values;
      if (unpacker.unpack(shorter, part, out) == UnpackError::none) REQUIRE(out != values);
    }
    WireBytes longer = good;
    longer.push_back(static_cast<std::uint8_t>(random.next()));
    REQUIRE(is_fine(longer, part));
    for (int k = 0; k < 20; ++k) {
      WireBytes flipped = good;
      flipped[random.below(static_cast<std::uint32_t>(good.size()))] ^=
          static_cast<std::uint8_t>(1U << random.below(8));
      REQUIRE(is_fine(flipped, part));
    }
  }
  for (int i = 0; i < 2000; ++i) {
    WireBytes noise(random.below(300));
    for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random.next());
    if (!noise.empty() && i % 2 == 0) noise[0] = static_cast<std::uint8_t>(33 + random.below(4));
    REQUIRE(is_fine(noise, kParts[random.below(3)]));
  }
  for (const UnpackError error : {UnpackError::empty, UnpackError::truncated, UnpackError::trailing_bytes,
                                  UnpackError::bad_level, UnpackError::wrong_end}) {
    CHECK(reasons.count(error) == 1);
    CHECK(std::string(to_string(error)) != "unknown");
  }
}

TEST_CASE("The format is what it was") {
  BlockValues values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const mapper::VoxelIndex v = mapper::decode(i);
    const auto shade = static_cast<std::uint8_t>(100 + 3 * v.x + v.y * v.y);
    values[i] = v.z > 3                     ? static_cast<mapper::Rgbo>(std::max(0, 14 - 2 * v.x - v.y))
                : v.z == 3 && v.x + v.y > 3 ? mapper::make_rgbo(shade, static_cast<std::uint8_t>(shade - 9), 70,
                                                                static_cast<std::uint8_t>(20 + 4 * (v.y % 4))) |
                                                  mapper::kHasColourBit
                                            : mapper::kUnknownRgbo;
  }
  const WireBytes low = packed_bytes(values, Part::low_half);
  const WireBytes high = packed_bytes(values, Part::high_half);
  CHECK(hex(low) ==
        "c0df5ba55fe9e4d1cadfe20dcc799d3db134d3da51bfee2ae407873cd4891d0ba0316353382791b422672e8eac4eb23a7cde"
        "c74605635fd4f1acdc59fc802d9e3102ae2211");
  CHECK(hex(high) == "7ca90c3c421d1777da058805e606b8c8f7676c139753d335f88a91866998611536a66c82f5");
  BlockUnpacker unpacker;
  BlockValues back;
  REQUIRE(unpacker.unpack(low, Part::low_half, back) == UnpackError::none);
  REQUIRE(unpacker.unpack(high, Part::high_half, back) == UnpackError::none);
  CHECK(back == values);
}
