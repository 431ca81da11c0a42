// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/submap_contents.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>

#include "mapper/files/block_codec.hpp"
#include "mapper/map_hash.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;

namespace {

std::vector<align::DepthSample> random_surfaces(tests::Random& random, int count) {
  std::vector<align::DepthSample> surfaces;
  const auto metres = [&] { return static_cast<float>(random.uniform(-50.0, 50.0)); };
  for (int i = 0; i < count; ++i) surfaces.push_back({{metres(), metres(), metres()}, {0.0F, 0.6F, -0.8F}, 0.25F});
  return surfaces;
}

SubmapContents random_contents(std::uint64_t seed, int blocks, int samples, int space_blocks) {
  tests::Random random(seed);
  SubmapContents contents;
  contents.voxels = tests::random_map(random.next(), blocks);
  contents.surfaces = random_surfaces(random, samples);
  if (space_blocks > 0) contents.space = tests::random_map(random.next(), space_blocks, 0.2F, false);
  return contents;
}

bool same_or_neither(const std::unique_ptr<VoxelMap>& a, const std::unique_ptr<VoxelMap>& b) {
  if (a == nullptr || b == nullptr) return a == b;
  return tests::same_map(*a, *b) && map_hash(*a) == map_hash(*b);
}

/// To the bit: a number that is none equals itself here.
bool same_surfaces(const std::vector<align::DepthSample>& a, const std::vector<align::DepthSample>& b) {
  if (a.size() != b.size()) return false;
  return a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(align::DepthSample)) == 0;
}

bool same(const SubmapContents& a, const SubmapContents& b) {
  return same_or_neither(a.voxels, b.voxels) && same_surfaces(a.surfaces, b.surfaces) &&
         same_or_neither(a.space, b.space);
}

void check_survives(const SubmapContents& contents) {
  const auto back = from_bytes(to_bytes(contents));
  REQUIRE(back.ok());
  CHECK(same(back.value(), contents));
}

/// No surfaces, and then whatever a test says.
Bytes no_surfaces() {
  Bytes bytes;
  put(bytes, std::uint32_t{0});
  put(bytes, static_cast<std::uint32_t>(sizeof(align::DepthSample)));
  return bytes;
}

void put_group(Bytes& bytes, const VoxelMap& map, std::span<const BlockKey> keys) {
  BlockEncoder encoder;
  const Bytes& group = encoder.encode(keys, map);
  put(bytes, static_cast<std::uint32_t>(group.size()));
  put_bytes(bytes, group);
}

void check_refused(const Bytes& bytes, hal::Reason reason, const std::string& named) {
  const auto contents = from_bytes(bytes);
  INFO(named);
  REQUIRE_FALSE(contents.ok());
  CHECK(contents.error().reason == reason);
  CHECK(contents.error().text.find(named) != std::string::npos);
}

}  // namespace

TEST_CASE("what a submap holds comes back from bytes to the bit", "[submaps][paging]") {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    INFO("seed " << seed);
    check_survives(random_contents(seed, static_cast<int>(20 * seed), static_cast<int>(37 * seed), 5));
  }
  SubmapContents odd = random_contents(20, 4, 3, 0);
  odd.surfaces[0].point_m = {-0.0F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()};
  odd.surfaces[1].weight = std::numeric_limits<float>::denorm_min();
  check_survives(odd);
}

TEST_CASE("a submap may have no surfaces, no space and not one block", "[submaps][paging]") {
  check_survives(random_contents(30, 50, 40, 0));
  check_survives(random_contents(31, 50, 0, 10));
  SubmapContents empty;
  empty.voxels = map_for_blocks(Grid{0.03F}, 0);
  check_survives(empty);
  const auto back = from_bytes(to_bytes(empty));
  REQUIRE(back.ok());
  CHECK(back.value().voxels->grid().resolution_m == 0.03F);
  CHECK(back.value().voxels->block_count() == 0);
  CHECK(back.value().space == nullptr);
}

TEST_CASE("a submap may have more blocks than a group holds", "[submaps][paging][slow]") {
  const SubmapContents large = random_contents(40, 9000, 10, 9000);
  REQUIRE(large.voxels->sorted_keys().size() > kMaxGroupBlocks);
  REQUIRE(large.space->sorted_keys().size() > kMaxGroupBlocks);
  check_survives(large);
}

TEST_CASE("a map for some blocks has room for those, whatever they hold, and no more", "[submaps][paging]") {
  const auto full = tests::random_map(3, 40);
  const std::vector<BlockKey> keys = full->sorted_keys();
  const auto map = map_for_blocks(full->grid(), keys.size());
  BlockValues values;
  for (const BlockKey key : keys) {
    REQUIRE(full->read_stored_block(key, values));
    CHECK(map->write_block(key, values));
  }
  CHECK(tests::same_map(*map, *full));
  CHECK_FALSE(map->write_block(keys.front() + 1, values));
}

TEST_CASE("memory of what a submap holds is that of all its parts", "[submaps][paging]") {
  SubmapContents contents = random_contents(50, 60, 100, 30);
  const std::uint64_t all_bytes = contents.memory_bytes();
  const std::uint64_t space_bytes = contents.space->memory().used_bytes;
  contents.space.reset();
  CHECK(contents.memory_bytes() == all_bytes - space_bytes);
  contents.surfaces.clear();
  CHECK(contents.memory_bytes() == contents.voxels->memory().used_bytes);
  CHECK(SubmapContents{}.memory_bytes() == 0);
}

TEST_CASE("every record of a submap that is cut off is refused as such", "[submaps][paging]") {
  const Bytes whole = to_bytes(random_contents(60, 6, 4, 3));
  for (std::size_t bytes = 0; bytes < whole.size(); ++bytes) {
    const auto contents = from_bytes(ByteSpan(whole).first(bytes));
    INFO(bytes << " of " << whole.size());
    REQUIRE_FALSE(contents.ok());
    CHECK(contents.error().reason == hal::Reason::truncated);
  }
}

TEST_CASE("a record of a submap with wrong bits is refused or a submap all the same", "[submaps][paging]") {
  const Bytes whole = to_bytes(random_contents(70, 6, 4, 3));
  tests::Random random(71);
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    Bytes wrong = whole;
    // Counts and sizes stand in few bytes: each of them has its turn.
    for (std::uint32_t flips = 1 + random.below(3); flips > 0; --flips) {
      const std::size_t at =
          i < 200 ? static_cast<std::size_t>(i) : random.below(static_cast<std::uint32_t>(wrong.size()));
      wrong[at % wrong.size()] ^= static_cast<std::uint8_t>(1U << random.below(8));
    }
    const auto contents = from_bytes(wrong);
    refused += contents.ok() ? 0 : 1;
    if (!contents.ok()) {
      CHECK_FALSE(contents.error().text.empty());
    } else {
      check_survives(contents.value());
    }
  }
  CHECK(refused > 300);
}

TEST_CASE("what is wrong with a record of a submap is said", "[submaps][paging]") {
  using hal::Reason;
  const SubmapContents good = random_contents(80, 6, 4, 3);
  Bytes other_size = to_bytes(good);
  other_size[4] ^= 1U;
  check_refused(other_size, Reason::malformed, "another size");

  Bytes longer = to_bytes(good);
  longer.push_back(0);
  check_refused(longer, Reason::malformed, "left over");

  SubmapContents without;
  without.space = tests::random_map(1, 3);
  check_refused(to_bytes(without), Reason::malformed, "without voxels");

  Bytes few = no_surfaces();
  few[0] = 1;  // says that there is one
  put(few, 0.0F);
  check_refused(few, Reason::truncated, "surfaces");

  for (const float resolution_m : {-0.05F, std::numeric_limits<float>::infinity(), std::nanf("")}) {
    Bytes bytes = no_surfaces();
    put(bytes, resolution_m);
    check_refused(bytes, Reason::malformed, "resolution");
  }
  Bytes countless = no_surfaces();
  put(countless, 0.05F);
  put(countless, std::uint32_t{0xFFFFFFFF});
  check_refused(countless, Reason::too_large, "more blocks");

  const std::vector<BlockKey> keys = good.voxels->sorted_keys();
  Bytes more = no_surfaces();
  put(more, 0.05F);
  put(more, static_cast<std::uint32_t>(keys.size() - 1));
  put_group(more, *good.voxels, keys);
  check_refused(more, Reason::malformed, "than announced");

  Bytes nothing = no_surfaces();
  put(nothing, 0.05F);
  put(nothing, std::uint32_t{2});
  put_group(nothing, *good.voxels, {});
  check_refused(nothing, Reason::malformed, "without blocks");

  Bytes no_group = no_surfaces();
  put(no_group, 0.05F);
  put(no_group, std::uint32_t{2});
  put(no_group, std::uint32_t{5});
  put_bytes(no_group, Bytes(5, 0));
  CHECK_FALSE(from_bytes(no_group).ok());
}
