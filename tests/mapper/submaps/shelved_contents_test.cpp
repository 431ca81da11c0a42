// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/shelved_contents.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <optional>

#include "tests/support/memory_page_file.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;
using tests::MemoryPageFile;

namespace {

SubmapContents contents_of(std::uint64_t seed) {
  SubmapContents contents;
  contents.voxels = tests::random_map(seed, 30);
  contents.surfaces.resize(9, {{1.0F, 2.0F, 3.0F}, {0.0F, 0.0F, 1.0F}, static_cast<float>(seed)});
  contents.space = tests::random_map(seed + 1, 8, 0.2F, false);
  return contents;
}

void check_holds(ShelvedContents& shelved, std::uint64_t seed) {
  CHECK(to_bytes(shelved.get()) == to_bytes(contents_of(seed)));
}

struct Shelf {
  MemoryPageFile* disk = new MemoryPageFile;
  SubmapShelf shelf{std::unique_ptr<PageFile>(disk)};
};

}  // namespace

TEST_CASE("what was put away is fetched as it was, and its keys are there meanwhile", "[submaps][paging]") {
  Shelf s;
  ShelvedContents shelved(contents_of(1), &s.shelf);
  const std::vector<BlockKey> keys = contents_of(1).voxels->sorted_keys();
  const std::uint64_t in_memory_bytes = shelved.memory_bytes();
  CHECK(in_memory_bytes == contents_of(1).memory_bytes() + keys.size() * sizeof(BlockKey));
  CHECK(shelved.is_in_memory());
  shelved.put_away();
  CHECK_FALSE(shelved.is_in_memory());
  CHECK(std::equal(keys.begin(), keys.end(), shelved.keys().begin(), shelved.keys().end()));
  CHECK(shelved.grid().resolution_m == 0.05F);
  CHECK(shelved.memory_bytes() == keys.size() * sizeof(BlockKey));
  check_holds(shelved, 1);
  CHECK(shelved.is_in_memory());
  CHECK(shelved.memory_bytes() > keys.size() * sizeof(BlockKey));
  CHECK(s.shelf.counts().put_away == 1);
  CHECK(s.shelf.counts().fetched == 1);
}

TEST_CASE("what never changes is written once", "[submaps][paging]") {
  Shelf s;
  ShelvedContents shelved(contents_of(2), &s.shelf);
  shelved.put_away();
  const std::uint64_t bytes = s.shelf.file_bytes();
  REQUIRE(bytes > 0);
  shelved.put_away();  // it is there already
  CHECK(s.shelf.counts().put_away == 1);
  check_holds(shelved, 2);
  s.disk->full_at_bytes = 0;
  shelved.put_away();
  CHECK_FALSE(shelved.is_in_memory());
  CHECK(s.shelf.size() == 1);
  CHECK(s.shelf.file_bytes() == bytes);
  CHECK(s.shelf.counts().put_away == 2);
  CHECK(s.shelf.counts().failed_stores == 0);
  check_holds(shelved, 2);
}

TEST_CASE("what a full disk does not take stays in memory until it does", "[submaps][paging]") {
  Shelf s;
  ShelvedContents shelved(contents_of(3), &s.shelf);
  s.disk->full_at_bytes = 100;
  shelved.put_away();
  shelved.put_away();
  CHECK(shelved.is_in_memory());
  CHECK(s.shelf.counts().failed_stores == 2);
  CHECK(s.shelf.counts().put_away == 0);
  check_holds(shelved, 3);
  CHECK(s.shelf.counts().fetched == 0);
  s.disk->full_at_bytes = ~std::uint64_t{0};
  shelved.put_away();
  CHECK_FALSE(shelved.is_in_memory());
  check_holds(shelved, 3);
}

TEST_CASE("of what cannot be read any more nothing is known, and it is counted once", "[submaps][paging]") {
  Shelf s;
  ShelvedContents other(contents_of(4), &s.shelf);
  ShelvedContents shelved(contents_of(5), &s.shelf);
  other.put_away();
  const auto at = static_cast<std::size_t>(s.shelf.file_bytes());
  shelved.put_away();
  s.disk->spoil(at + 40);
  for (int again = 0; again < 3; ++again) {
    const SubmapContents& lost = shelved.get();
    REQUIRE(lost.voxels != nullptr);
    CHECK(lost.voxels->grid() == shelved.grid());
    CHECK(lost.voxels->block_count() == 0);
    CHECK(lost.surfaces.empty());
    CHECK(lost.space == nullptr);
    CHECK(s.shelf.counts().failed_loads == 1);
    shelved.put_away();  // not in the place of what is lost
    CHECK(s.shelf.size() == 1);
  }
  CHECK_FALSE(shelved.keys().empty());
  CHECK_FALSE(s.shelf.first_error().empty());
  check_holds(other, 4);
}

TEST_CASE("without a shelf all of it stays in memory", "[submaps][paging]") {
  ShelvedContents shelved(contents_of(6));
  shelved.put_away();
  CHECK(shelved.is_in_memory());
  check_holds(shelved, 6);
  CHECK(shelved.last_use() == 0);
}

TEST_CASE("who goes leaves nothing on the shelf", "[submaps][paging]") {
  Shelf s;
  std::optional<ShelvedContents> first(std::in_place, contents_of(7), &s.shelf);
  std::optional<ShelvedContents> second(std::in_place, contents_of(8), &s.shelf);
  std::optional<ShelvedContents> never_put_away(std::in_place, contents_of(9), &s.shelf);
  first->put_away();
  second->put_away();
  check_holds(*first, 7);  // in memory and on the shelf
  first.reset();
  never_put_away.reset();
  CHECK(s.shelf.size() == 1);
  check_holds(*second, 8);
  second.reset();
  CHECK(s.shelf.size() == 0);
  CHECK(s.disk->size() == 0);
}

TEST_CASE("on one shelf it can be told what was used longest ago", "[submaps][paging]") {
  Shelf s;
  ShelvedContents first(contents_of(10), &s.shelf);
  ShelvedContents second(contents_of(11), &s.shelf);
  CHECK(first.last_use() < second.last_use());
  (void)first.get();
  CHECK(first.last_use() > second.last_use());
  second.put_away();  // no use
  CHECK(first.last_use() > second.last_use());
  (void)second.get();
  CHECK(first.last_use() < second.last_use());
}
