// SPDX-License-Identifier: Apache-2.0
#include "net/record_key.hpp"

#include <catch2/catch.hpp>
#include <set>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using net::Part;
using net::RecordKey;
using net::RecordKind;

namespace {

constexpr mapper::BlockKey kLastBlockKey = (mapper::BlockKey{1} << 39) - 1;
constexpr std::array<Part, net::kParts> kAllParts{Part::whole, Part::low_half, Part::high_half};

}  // namespace

TEST_CASE("the key of a block says its submap, its block and its part again", "[net]") {
  tests::Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const std::uint32_t submap = i == 0 ? net::kMaxSubmaps - 1 : random.below(net::kMaxSubmaps);
    const mapper::BlockKey block = i < 2 ? kLastBlockKey : random.next() & kLastBlockKey;
    for (const Part part : kAllParts) {
      const RecordKey key = net::block_record(submap, block, part);
      REQUIRE(net::is_record_key(key));
      REQUIRE(key < RecordKey{1} << net::kRecordKeyBits);
      REQUIRE(net::kind_of(key) == RecordKind::block);
      REQUIRE(net::submap_of_key(key) == submap);
      REQUIRE(net::block_key_of(key) == block);
      REQUIRE(net::part_of(key) == part);
      for (const Part other : kAllParts) REQUIRE(net::with_part(key, other) == net::block_record(submap, block, other));
    }
  }
}

TEST_CASE("keys of poses and of what a robot says of itself are of their kind", "[net]") {
  for (const std::uint32_t submap : {0U, 1U, 17U, net::kMaxSubmaps - 1}) {
    const RecordKey key = net::pose_record(submap);
    CHECK(net::is_record_key(key));
    CHECK(net::kind_of(key) == RecordKind::submap_pose);
    CHECK(net::submap_of_key(key) == submap);
    CHECK(net::part_of(key) == Part::whole);
  }
  for (const std::uint32_t number : {0U, 1U, 1000U, 0xFFFFFFFFU}) {
    const RecordKey key = net::status_record(number);
    CHECK(net::is_record_key(key));
    CHECK(net::kind_of(key) == RecordKind::status);
    CHECK(net::block_key_of(key) == number);
    CHECK(net::part_of(key) == Part::whole);
  }
}

TEST_CASE("no two things have the same key, and blocks of a submap stand together in the order of their blocks",
          "[net]") {
  std::set<RecordKey> keys;
  std::size_t made = 0;
  RecordKey before = 0;
  for (std::uint32_t submap = 0; submap < 5; ++submap) {
    for (const mapper::BlockKey block : {mapper::BlockKey{0}, mapper::BlockKey{1}, kLastBlockKey}) {
      for (const Part part : kAllParts) {
        const RecordKey key = net::block_record(submap, block, part);
        CHECK((made == 0 || key > before));
        before = key;
        keys.insert(key);
        ++made;
      }
    }
  }
  for (std::uint32_t i = 0; i < 5; ++i, made += 2) {
    keys.insert(net::pose_record(i));
    keys.insert(net::status_record(i));
  }
  CHECK(keys.size() == made);
}

TEST_CASE("what has no kind, no part or more bits than a key is no key", "[net]") {
  const RecordKey good = net::block_record(4095, kLastBlockKey, Part::high_half);
  REQUIRE(net::is_record_key(good));
  CHECK_FALSE(net::is_record_key(good | 3U));
  CHECK_FALSE(net::is_record_key(RecordKey{3} << 53));
  CHECK_FALSE(net::is_record_key(~RecordKey{0}));
  CHECK_FALSE(net::is_record_key(~RecordKey{3}));
  for (int bit = net::kRecordKeyBits; bit < 64; ++bit) CHECK_FALSE(net::is_record_key(good | RecordKey{1} << bit));
}
