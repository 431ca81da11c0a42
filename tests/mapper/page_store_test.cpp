// SPDX-License-Identifier: Apache-2.0
// The page store against a plain std::map, and against a disk that is full or lies.
#include "mapper/page_store.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>

#include "tests/support/memory_page_file.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;
using tests::MemoryPageFile;

namespace {

using Blocks = std::vector<StoredBlock>;

Blocks some_blocks(RegionKey region, tests::Random& random) {
  Blocks blocks;
  for (std::uint32_t place = 0; place < kRegionBlocks; place += 1 + random.below(200)) {
    StoredBlock block;
    block.key = first_block(region) + place;
    const bool uniform = random.below(3) == 0;
    const auto level = random.below(15);
    for (Rgbo& value : block.values) {
      value = uniform ? level : random.below(33);
      if (state_of(value) == State::occupied && random.below(2) == 0) {
        value |= kHasColourBit | (random.below(1U << 24) << 8);
      }
    }
    blocks.push_back(block);
  }
  return blocks;
}

bool same(std::span<const StoredBlock> a, const Blocks& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const StoredBlock& x, const StoredBlock& y) { return x.key == y.key && x.values == y.values; });
}

void put(PageStore& store, RegionKey region, const Blocks& blocks) {
  const auto record = store.put(region, blocks);
  REQUIRE(record.ok());
  store.commit(region, record.value());
}

}  // namespace

TEST_CASE("a region comes back as it was put", "[mapper][paging]") {
  tests::Random random(1);
  PageStore store(std::make_unique<MemoryPageFile>(), 16);
  const RegionKey last = (RegionKey{1} << 30) - 1;
  for (const RegionKey region : {RegionKey{0}, RegionKey{77}, last}) put(store, region, some_blocks(region, random));
  const Blocks blocks = some_blocks(77, random);
  put(store, 77, blocks);  // the newer one counts
  const auto got = store.get(77);
  REQUIRE(got.ok());
  CHECK(same(got.value(), blocks));
  CHECK(store.sorted_regions() == std::vector<RegionKey>{0, 77, last});
  CHECK(store.get(5).error().reason == hal::Reason::not_found);
  CHECK(store.drop(77));
  CHECK_FALSE(store.drop(77));
  CHECK(store.get(77).error().reason == hal::Reason::not_found);
}

TEST_CASE("a record says what its blocks need in memory", "[mapper][paging]") {
  tests::Random random(2);
  PageStore store(std::make_unique<MemoryPageFile>(), 16);
  const Blocks blocks = some_blocks(9, random);
  put(store, 9, blocks);
  const PageRecord& record = *store.find(9);
  VoxelMap map(Grid{}, record.needed());
  for (const StoredBlock& block : blocks) CHECK(map.write_block(block.key, block.values));
  CHECK(map.available().blocks == 0);
  CHECK(map.available().planes == 0);
  CHECK(map.available().colour_bricks == 0);
}

TEST_CASE("what is not committed changes nothing", "[mapper][paging]") {
  tests::Random random(3);
  PageStore store(std::make_unique<MemoryPageFile>(), 16);
  const Blocks old_blocks = some_blocks(4, random);
  put(store, 4, old_blocks);
  const std::uint64_t live_bytes = store.live_bytes();
  const auto record = store.put(4, some_blocks(4, random));
  REQUIRE(record.ok());
  CHECK(same(store.get(4).value(), old_blocks));
  store.abandon(record.value());
  CHECK(same(store.get(4).value(), old_blocks));
  CHECK(store.live_bytes() == live_bytes);
}

TEST_CASE("random puts, drops and gets agree with a plain map, and garbage stays below half", "[mapper][paging]") {
  tests::Random random(4);
  auto file = std::make_unique<MemoryPageFile>();
  const MemoryPageFile& disk = *file;
  PageStore store(std::move(file), 64);
  std::map<RegionKey, Blocks> plain;
  for (int i = 0; i < 1500; ++i) {
    const RegionKey region = 1000 + random.below(40);
    const std::uint32_t what = random.below(10);
    if (what < 6) {
      plain[region] = some_blocks(region, random);
      put(store, region, plain[region]);
    } else if (what < 8) {
      CHECK(store.drop(region) == (plain.erase(region) > 0));
    } else {
      const auto got = store.get(region);
      REQUIRE(got.ok() == plain.contains(region));
      if (got.ok()) CHECK(same(got.value(), plain[region]));
    }
    REQUIRE(store.file_bytes() <= std::max<std::uint64_t>(2 * store.live_bytes(), store.live_bytes() + (1U << 16)));
  }
  std::uint64_t blocks = 0;
  for (const auto& [region, expected] : plain) {
    CHECK(same(store.get(region).value(), expected));
    blocks += expected.size();
  }
  CHECK(store.region_count() == plain.size());
  CHECK(store.block_count() == blocks);
  CHECK(disk.size() < 1'000'000);  // fifteen hundred records were written
}

TEST_CASE("a full disk is an error and spoils nothing", "[mapper][paging]") {
  tests::Random random(5);
  auto file = std::make_unique<MemoryPageFile>();
  MemoryPageFile& disk = *file;
  PageStore store(std::move(file), 64);
  const Blocks blocks = some_blocks(1, random);
  put(store, 1, blocks);
  disk.full_at_bytes = store.file_bytes() + 10;
  CHECK(store.put(2, some_blocks(2, random)).error().reason == hal::Reason::disk_full);
  CHECK(store.put(1, some_blocks(1, random)).error().reason == hal::Reason::disk_full);
  CHECK(same(store.get(1).value(), blocks));
  disk.full_at_bytes = ~std::uint64_t{0};
  put(store, 2, blocks.empty() ? blocks : some_blocks(2, random));
  CHECK(store.region_count() == 2);
}

TEST_CASE("a disk that forgets is caught while the blocks are still in memory", "[mapper][paging]") {
  tests::Random random(6);
  auto file = std::make_unique<MemoryPageFile>();
  file->spoil_writes = true;
  PageStore store(std::move(file), 64);
  CHECK(store.put(1, some_blocks(1, random)).error().reason == hal::Reason::bad_checksum);
  CHECK(store.region_count() == 0);
}

TEST_CASE("every spoiled byte of a record is noticed", "[mapper][paging]") {
  tests::Random random(7);
  auto file = std::make_unique<MemoryPageFile>();
  MemoryPageFile& disk = *file;
  PageStore store(std::move(file), 64);
  put(store, 1, some_blocks(1, random));
  const std::size_t bytes = disk.size();
  for (std::size_t i = 0; i < bytes; i += i < 64 ? 1 : 1 + random.below(500)) {
    disk.spoil(i);
    CHECK_FALSE(store.get(1).ok());
    disk.spoil(i);
  }
  CHECK(store.get(1).ok());
}

TEST_CASE("an old record in the place of a new one is noticed", "[mapper][paging]") {
  tests::Random random(8);
  auto file = std::make_unique<MemoryPageFile>();
  MemoryPageFile& disk = *file;
  PageStore store(std::move(file), 64);
  const Blocks blocks = some_blocks(1, random);
  put(store, 1, blocks);
  std::vector<std::uint8_t> old_record(store.file_bytes());
  REQUIRE(disk.read(0, old_record).ok());
  const std::uint64_t offset = store.file_bytes();
  put(store, 1, blocks);
  REQUIRE(disk.write(offset, old_record).ok());  // a valid checksum, but another version
  CHECK(store.get(1).error().reason == hal::Reason::malformed);
}

TEST_CASE("a full index refuses new regions and takes known ones", "[mapper][paging]") {
  tests::Random random(9);
  PageStore store(std::make_unique<MemoryPageFile>(), 2);
  put(store, 1, some_blocks(1, random));
  put(store, 2, some_blocks(2, random));
  CHECK(store.put(3, some_blocks(3, random)).error().reason == hal::Reason::no_capacity);
  put(store, 2, some_blocks(2, random));
  store.drop(1);
  put(store, 3, some_blocks(3, random));
}
