// SPDX-License-Identifier: Apache-2.0
// The shelf against a plain map, and against a disk that is full or lies.
#include "mapper/submaps/submap_shelf.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>

#include "tests/support/memory_page_file.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;
using tests::MemoryPageFile;

namespace {

constexpr std::uint64_t kNeverFull = ~std::uint64_t{0};

SubmapContents contents_of(std::uint64_t seed, int blocks = 5) {
  SubmapContents contents;
  contents.voxels = tests::random_map(seed, blocks);
  contents.surfaces.resize(seed % 7, {{1.0F, 2.0F, 3.0F}, {0.0F, 0.0F, 1.0F}, static_cast<float>(seed)});
  return contents;
}

/// A shelf whose disk one can get at.
struct Shelf {
  MemoryPageFile* disk = new MemoryPageFile;
  SubmapShelf shelf{std::unique_ptr<PageFile>(disk)};

  SubmapShelf::Number put(std::uint64_t seed, int blocks = 5) {
    const auto number = shelf.put(contents_of(seed, blocks));
    REQUIRE(number.ok());
    return number.value();
  }
  void check(SubmapShelf::Number number, std::uint64_t seed, int blocks = 5) {
    const auto got = shelf.fetch(number);
    REQUIRE(got.ok());
    CHECK(to_bytes(got.value()) == to_bytes(contents_of(seed, blocks)));
  }
};

}  // namespace

TEST_CASE("submaps come back from the shelf as often as one likes, under numbers of their own", "[submaps][paging]") {
  Shelf s;
  const auto a = s.put(1);
  const auto b = s.put(2, 40);
  const auto c = s.put(1);
  CHECK(a != SubmapShelf::kNone);
  CHECK((a != b && b != c && a != c));
  CHECK(s.shelf.size() == 3);
  CHECK(s.disk->size() == s.shelf.file_bytes());
  for (int again = 0; again < 2; ++again) {
    s.check(b, 2, 40);
    s.check(c, 1);
    s.check(a, 1);
  }
  CHECK(s.shelf.first_error().empty());
}

TEST_CASE("what was dropped or never put is not found", "[submaps][paging]") {
  Shelf s;
  const auto a = s.put(1);
  const auto b = s.put(2);
  s.shelf.drop(a);
  s.shelf.drop(a);
  s.shelf.drop(77);
  CHECK(s.shelf.size() == 1);
  CHECK(s.shelf.fetch(a).error().reason == hal::Reason::not_found);
  CHECK(s.shelf.fetch(SubmapShelf::kNone).error().reason == hal::Reason::not_found);
  CHECK(s.shelf.first_error().find("submap 1 was never written") != std::string::npos);
  s.check(b, 2);
}

TEST_CASE("a record goes into the first gap that has room for it", "[submaps][paging]") {
  Shelf s;
  const auto small = s.put(1, 3);
  const auto large = s.put(2, 60);
  const auto medium = s.put(3, 20);
  const auto last = s.put(4, 3);
  const std::uint64_t bytes = s.shelf.file_bytes();

  s.shelf.drop(large);
  s.shelf.drop(small);
  CHECK(s.shelf.file_bytes() == bytes);  // the last one still lies at the end
  const auto in_gap = s.put(2, 60);
  const auto in_gap_too = s.put(1, 3);
  CHECK(s.shelf.file_bytes() == bytes);
  CHECK(s.disk->size() == bytes);
  s.check(in_gap, 2, 60);
  s.check(in_gap_too, 1, 3);
  s.check(medium, 3, 20);
  s.check(last, 4, 3);

  // One that fits into no gap goes to the end.
  s.shelf.drop(in_gap_too);
  const auto at_end = s.put(5, 200);
  CHECK(s.shelf.file_bytes() > bytes);
  s.check(at_end, 5, 200);
  s.check(in_gap, 2, 60);
  // The file ends where the last record does.
  s.shelf.drop(at_end);
  CHECK(s.disk->size() == bytes);
  for (const auto number : {last, medium, in_gap}) s.shelf.drop(number);
  CHECK(s.shelf.file_bytes() == 0);
  CHECK(s.disk->size() == 0);
}

TEST_CASE("random puts, drops and fetches agree with a plain map, and gaps do not add up", "[submaps][paging]") {
  Shelf s;
  tests::Random random(5);
  struct Put {
    std::uint64_t seed;
    int blocks;
  };
  std::map<SubmapShelf::Number, Put> plain;
  std::uint64_t most_bytes = 0;
  for (int i = 0; i < 600; ++i) {
    const auto any = [&] { return std::next(plain.begin(), random.below(static_cast<std::uint32_t>(plain.size()))); };
    if (plain.size() < 12 && random.below(2) == 0) {
      const Put put{random.below(1000), 2 + static_cast<int>(random.below(12))};
      const auto number = s.put(put.seed, put.blocks);
      REQUIRE(plain.emplace(number, put).second);
    } else if (!plain.empty() && random.below(2) == 0) {
      const auto one = any();
      s.shelf.drop(one->first);
      plain.erase(one);
    } else if (!plain.empty()) {
      const auto one = any();
      s.check(one->first, one->second.seed, one->second.blocks);
    }
    REQUIRE(s.shelf.size() == plain.size());
    most_bytes = std::max(most_bytes, s.shelf.file_bytes());
  }
  for (const auto& [number, put] : plain) s.check(number, put.seed, put.blocks);
  Shelf largest;
  for (std::uint64_t seed = 0; seed < 12; ++seed) largest.put(seed, 14);
  CHECK(most_bytes < 2 * largest.shelf.file_bytes());
}

TEST_CASE("every spoiled byte of a submap's record is noticed", "[submaps][paging]") {
  Shelf s;
  s.put(1);
  const std::size_t first = s.disk->size();
  const auto b = s.put(2);
  tests::Random random(7);
  for (std::size_t i = first; i < s.disk->size(); i += i < first + 64 ? 1 : 1 + random.below(20)) {
    s.disk->spoil(i);
    INFO("byte " << i - first);
    const auto got = s.shelf.fetch(b);
    REQUIRE_FALSE(got.ok());
    CHECK(got.error().reason == hal::Reason::bad_checksum);
    s.disk->spoil(i);
  }
  s.check(b, 2);
  CHECK(s.shelf.first_error().find("submap 2 came back with a wrong checksum") != std::string::npos);
}

TEST_CASE("another submap's record in the place of one is noticed", "[submaps][paging]") {
  Shelf s;
  s.put(1);
  std::vector<std::uint8_t> record(s.shelf.file_bytes());
  REQUIRE(s.disk->read(0, record).ok());
  const auto b = s.put(1);
  REQUIRE(s.disk->write(record.size(), record).ok());  // a valid checksum, but another number
  CHECK(s.shelf.fetch(b).error().reason == hal::Reason::bad_checksum);
}

TEST_CASE("a full disk is an error, spoils nothing and is told of once", "[submaps][paging]") {
  Shelf s;
  const auto a = s.put(1, 30);
  const auto b = s.put(2);
  const std::uint64_t bytes = s.shelf.file_bytes();
  s.disk->full_at_bytes = bytes + 10;
  CHECK(s.shelf.put(contents_of(3)).error().reason == hal::Reason::disk_full);
  CHECK(s.shelf.size() == 2);
  CHECK(s.shelf.file_bytes() == bytes);
  s.check(a, 1, 30);
  s.check(b, 2);
  // There is still room in a gap.
  s.shelf.drop(a);
  const auto c = s.put(3);
  CHECK(s.shelf.file_bytes() == bytes);
  s.disk->full_at_bytes = kNeverFull;
  const auto d = s.put(4, 60);
  s.check(b, 2);
  s.check(c, 3);
  s.check(d, 4, 60);
  CHECK_FALSE(s.shelf.fetch(a).ok());
  CHECK(s.shelf.first_error() == "page file: the disk is full");
}

TEST_CASE("a disk that forgets is caught while the submap is still in memory", "[submaps][paging]") {
  Shelf s;
  const auto a = s.put(1);
  s.disk->spoil_writes = true;
  CHECK(s.shelf.put(contents_of(2)).error().reason == hal::Reason::bad_checksum);
  CHECK(s.shelf.size() == 1);
  s.disk->spoil_writes = false;
  const auto c = s.put(3);
  s.check(a, 1);
  s.check(c, 3);
  CHECK(s.shelf.first_error().find("wrong checksum") != std::string::npos);
}

TEST_CASE("uses of a shelf are numbered", "[submaps][paging]") {
  Shelf s;
  const std::uint64_t first = s.shelf.next_use();
  CHECK(s.shelf.next_use() > first);
}
