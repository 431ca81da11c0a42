// SPDX-License-Identifier: Apache-2.0
#include "mapper/windowed_blocks.hpp"

#include <catch2/catch.hpp>

#include "mapper/map_hash.hpp"
#include "mapper/merge.hpp"
#include "tests/support/memory_page_file.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;
using tests::MemoryPageFile;

namespace {

/// Moves (or copies) every region that `picks` from the map to the store.
template <typename Picks>
void page_out(VoxelMap& map, PageStore& store, Picks&& picks, bool keep = false) {
  std::vector<BlockKey> gone;
  const auto done = MemoryBlocks(map).visit_regions([&](std::span<const StoredBlock> blocks) -> hal::Result<void> {
    const RegionKey region = region_of(blocks.front().key);
    if (!picks(region)) return {};
    const auto record = store.put(region, blocks);
    if (!record) return record.error();
    store.commit(region, record.value());
    for (const StoredBlock& block : blocks) gone.push_back(block.key);
    return {};
  });
  REQUIRE(done.ok());
  for (const BlockKey key : gone) {
    if (!keep) map.erase_block(key);
  }
}

}  // namespace

TEST_CASE("wherever the regions lie, the whole has one hash", "[mapper][paging]") {
  const auto map = tests::random_map(6, 3000);
  const std::string hash = map_hash(*map);
  const MapCounts counts = measure(MemoryBlocks(*map)).value().counts;
  PageStore store(std::make_unique<MemoryPageFile>(), 1000);
  tests::Random random(1);
  const auto which = GENERATE(0U, 1U, 2U);  // none, some, all
  page_out(*map, store, [&](RegionKey) { return random.below(2) < which; });
  const WindowedBlocks whole(*map, store);
  CHECK(map_hash(whole) == hash);
  CHECK((measure(whole).value().counts == counts));
  CHECK(whole.unreadable_regions() == 0);

  CHECK(gather(*map, store));
  CHECK(store.region_count() == 0);
  CHECK(map_hash(*map) == hash);
}

TEST_CASE("what is in memory and on disk is merged", "[mapper][paging]") {
  const auto older = tests::random_map(7, 800);
  const auto newer = tests::random_map(8, 800);
  const std::vector<MergeSource> sources{{older.get(), {}, 1}, {newer.get(), {}, 2}};
  const auto merged = merge_maps(sources);
  REQUIRE(merged.ok());
  PageStore store(std::make_unique<MemoryPageFile>(), 1000);
  page_out(*older, store, [](RegionKey) { return true; });
  CHECK(map_hash(WindowedBlocks(*newer, store)) == map_hash(*merged.value()));
}

TEST_CASE("what does not fit stays on disk, and the whole is still the whole", "[mapper][paging]") {
  const auto map = tests::random_map(9, 2000);
  const std::string hash = map_hash(*map);
  PageStore store(std::make_unique<MemoryPageFile>(), 1000);
  page_out(*map, store, [](RegionKey) { return true; });
  VoxelMap small(map->grid(), {600, 600, 4000});
  CHECK_FALSE(gather(small, store));
  CHECK(store.region_count() > 0);
  CHECK(map_hash(WindowedBlocks(small, store)) == hash);
}

TEST_CASE("a region that cannot be read is left out and counted", "[mapper][paging]") {
  const auto map = tests::random_map(10, 2000);
  auto file = std::make_unique<MemoryPageFile>();
  MemoryPageFile& disk = *file;
  PageStore store(std::move(file), 1000);
  page_out(*map, store, [](RegionKey) { return true; });
  const MapCounts before = measure(WindowedBlocks(*map, store)).value().counts;
  disk.spoil(100);
  const WindowedBlocks whole(*map, store);
  const MapCounts after = measure(whole).value().counts;
  CHECK(whole.unreadable_regions() == 1);
  CHECK_FALSE(whole.first_error().empty());
  CHECK(after.blocks < before.blocks);
  CHECK(after.blocks > 0);
  CHECK(map_hash(whole) == map_hash(whole));
}
