// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/submap_blocks.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/support/submap_walk.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;
using tests::SubmapWalk;

namespace {

struct Visited {
  std::vector<StoredBlock> blocks;
  std::vector<RegionKey> regions;
};

Visited visit(const BlockSource& source) {
  Visited visited;
  const auto done = source.visit_regions([&](std::span<const StoredBlock> blocks) -> hal::Result<void> {
    REQUIRE_FALSE(blocks.empty());
    visited.regions.push_back(region_of(blocks.front().key));
    for (const StoredBlock& block : blocks) {
      CHECK(region_of(block.key) == visited.regions.back());
      visited.blocks.push_back(block);
    }
    return {};
  });
  CHECK(done.ok());
  return visited;
}

bool same(const std::vector<StoredBlock>& a, const std::vector<StoredBlock>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const StoredBlock& x, const StoredBlock& y) { return x.key == y.key && x.values == y.values; });
}

bool ascends(const Visited& visited) {
  const auto by_key = [](const StoredBlock& x, const StoredBlock& y) { return x.key < y.key; };
  return std::is_sorted(visited.blocks.begin(), visited.blocks.end(), by_key) &&
         std::adjacent_find(visited.regions.begin(), visited.regions.end(), std::greater_equal<>()) ==
             visited.regions.end();
}

constexpr ChainOptions kManySubmaps{.most_way_m = 0.8};

}  // namespace

TEST_CASE("view and submaps together are the blocks of the whole map in their order, few in memory at a time",
          "[submaps][window][slow]") {
  SubmapWalk unlimited(kManySubmaps);
  SubmapWalk paged(kManySubmaps);
  paged.open_window();
  unlimited.go(130);
  paged.go(130);  // in the middle of a submap
  REQUIRE(paged.window->out_count() > 0);
  REQUIRE(paged.chain.submaps().size() > SubmapBlocks::kKept);
  const SubmapBlocks whole(paged.chain, *paged.window);
  CHECK(whole.grid() == unlimited.chain.view().grid());

  const Visited expected = visit(MemoryBlocks(unlimited.chain.view()));
  const Visited visited = visit(whole);
  CHECK(ascends(visited));
  CHECK(visited.regions == expected.regions);
  CHECK(same(visited.blocks, expected.blocks));
  CHECK(paged.chain.in_memory() <= SubmapBlocks::kKept);
  CHECK(same(visit(whole).blocks, expected.blocks));
  CHECK(paged.chain.in_memory() <= SubmapBlocks::kKept);
  CHECK(paged.shelf.counts().failed_loads == 0);
}

TEST_CASE("a visit of view and submaps ends where somebody fails", "[submaps][window][slow]") {
  SubmapWalk paged(kManySubmaps);
  paged.open_window();
  paged.go(100);
  REQUIRE(paged.window->out_count() > 0);
  int visits = 0;
  const auto done = SubmapBlocks(paged.chain, *paged.window).visit_regions([&](std::span<const StoredBlock>) {
    return ++visits == 3 ? hal::Result<void>(hal::Error{hal::Reason::disk_full, "full"}) : hal::Result<void>();
  });
  REQUIRE_FALSE(done.ok());
  CHECK(done.error().text == "full");
  CHECK(visits == 3);
}

TEST_CASE("what the disk has lost is missing from the whole map, and nothing else", "[submaps][window][slow]") {
  SubmapWalk unlimited(kManySubmaps);
  SubmapWalk paged(kManySubmaps);
  paged.open_window();
  unlimited.go(130);
  paged.go(130);
  REQUIRE(paged.shelf.size() > 5);
  paged.disk->spoil(30);
  const Visited expected = visit(MemoryBlocks(unlimited.chain.view()));
  const Visited visited = visit(SubmapBlocks(paged.chain, *paged.window));
  CHECK(paged.shelf.counts().failed_loads == 1);
  CHECK(ascends(visited));
  const auto is_like = [](const StoredBlock& a, const StoredBlock& b) {
    return a.key == b.key && a.values == b.values;
  };
  std::size_t alike = 0;
  auto next = expected.blocks.begin();
  for (const StoredBlock& block : visited.blocks) {
    next = std::find_if(next, expected.blocks.end(), [&](const StoredBlock& other) { return other.key == block.key; });
    REQUIRE(next != expected.blocks.end());
    alike += is_like(block, *next) ? 1 : 0;
  }
  CHECK(alike > expected.blocks.size() * 3 / 4);
  CHECK(alike < expected.blocks.size());
}
