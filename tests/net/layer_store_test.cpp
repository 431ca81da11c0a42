// SPDX-License-Identifier: Apache-2.0
#include "net/layer_store.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "tests/net/plain_layer.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using mapper::Bytes;
using net::Lane;
using net::LayerIndex;
using net::LayerStore;
using net::Part;
using net::RecordKey;
using net::Version;
using tests::chunks_of;
using tests::PlainLayer;
using tests::PlainStored;
using Put = net::LayerStore::Put;

namespace {

RecordKey random_store_key(tests::Random& random, std::uint32_t blocks) {
  // Only blocks have halves that mean something; other keys with a part are just other keys.
  if (random.below(4) == 0) {
    const RecordKey key =
        random.below(2) == 0 ? net::pose_record(random.below(2)) : net::status_record(random.below(2));
    return net::with_part(key, static_cast<Part>(random.below(3)));
  }
  const std::uint32_t submap = random.below(2);
  const mapper::BlockKey block = random.below(blocks);
  return net::block_record(submap, block, static_cast<Part>(random.below(3)));
}
Bytes random_store_payload(tests::Random& random, std::uint32_t most_bytes) {
  Bytes payload(random.below(most_bytes + 1));
  for (std::uint8_t& byte : payload) byte = static_cast<std::uint8_t>(random.next());
  return payload;
}
Bytes payload_in(const LayerStore& store, const net::StoredRecord& record) {
  Bytes payload(record.bytes);
  store.read(record, payload);
  return payload;
}

/// The lanes of a layer, walked from end to end, are those of the plain one.
void check_lanes_are_the_same(const LayerStore& store, LayerIndex layer, const PlainLayer& plain) {
  REQUIRE(store.record_count(layer) == plain.records().size());
  std::vector<RecordKey> walked, expected;
  store.for_each(layer, [&](const net::StoredRecord& record) { walked.push_back(record.key); });
  for (const Lane lane : net::kAllLanes) {
    Version at = 0;
    for (const auto& [version, key] : plain.lane(lane)) {
      expected.push_back(key);
      const auto record = store.first_after(layer, lane, at);
      REQUIRE(record);
      REQUIRE(record->version == version);
      REQUIRE(record->key == key);
      REQUIRE(record->lane == lane);
      const Bytes& payload = plain.records().at(key).payload;
      REQUIRE(payload_in(store, *record) == payload);
      REQUIRE(store.holds(*record, payload));
      if (!payload.empty()) REQUIRE_FALSE(store.holds(*record, mapper::ByteSpan(payload).first(payload.size() - 1)));
      at = version;
    }
    REQUIRE_FALSE(store.first_after(layer, lane, at));
  }
  REQUIRE(walked == expected);
}

struct OfferedRecord {
  std::uint64_t robot = 0;
  RecordKey key = 0;
  Version version = 0;
  Lane lane = Lane::rest;
  Bytes payload;
};

/// What honest writers publish: every version of a layer once.
std::vector<OfferedRecord> published_records(tests::Random& random, int count) {
  std::vector<OfferedRecord> records;
  std::map<std::uint64_t, Version> versions;
  for (int i = 0; i < count; ++i) {
    const std::uint64_t robot = 1 + random.below(3);
    records.push_back({robot, random_store_key(random, 12), ++versions[robot], static_cast<Lane>(random.below(3)),
                       random_store_payload(random, 60)});
  }
  return records;
}

void put_into(LayerStore& store, const OfferedRecord& record) {
  const LayerIndex layer = store.find_or_add({record.robot, 1});
  const Put put = store.put(layer, record.key, record.version, record.lane, record.payload);
  REQUIRE((put == Put::stored || put == Put::superseded));
}

/// What must stand in the end of all that was offered, whatever the order.
std::map<RecordKey, Version> standing_of(const std::vector<OfferedRecord>& offered, std::uint64_t robot) {
  std::map<RecordKey, Version> newest;
  for (const OfferedRecord& record : offered) {
    if (record.robot == robot) newest[record.key] = std::max(newest[record.key], record.version);
  }
  std::map<RecordKey, Version> standing;
  for (const auto& [key, version] : newest) {
    const auto newest_part = [&, k = key](Part part) {
      const auto it = newest.find(net::with_part(k, part));
      return it == newest.end() ? 0 : it->second;
    };
    const bool is_block = net::kind_of(key) == net::RecordKind::block;
    const bool is_whole = net::part_of(key) == Part::whole;
    const bool is_covered = is_block && (is_whole ? std::min(newest_part(Part::low_half), newest_part(Part::high_half))
                                                  : newest_part(Part::whole)) > version;
    if (!is_covered) standing[key] = version;
  }
  return standing;
}

}  // namespace

TEST_CASE("a store does what std::map does, and refuses only when it is full, losing nothing then", "[net]") {
  constexpr std::uint32_t kRecords = 40;
  constexpr std::size_t kChunks = 70;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    tests::Random random(seed);
    LayerStore store({3, kRecords, kChunks * 36});
    std::array<PlainLayer, 3> plain;
    for (std::uint64_t l = 0; l < 3; ++l) REQUIRE(store.find_or_add({l + 1, 5}) == l);
    // Short payloads let the records run out first, long ones the memory for payloads.
    const std::uint32_t most_bytes = seed % 2 == 0 ? 10 : 150;
    std::array<int, 4> outcomes{};
    for (int step = 0; step < 1500; ++step) {
      INFO("seed " << seed << " step " << step);
      const LayerIndex layer = random.below(3);
      const RecordKey key = random_store_key(random, 6);
      const Version version = 1 + random.below(10 + static_cast<std::uint32_t>(step) / 4);
      const PlainStored record{version, static_cast<Lane>(random.below(3)), random_store_payload(random, most_bytes)};
      PlainLayer& of = plain[layer];
      std::size_t count = 0, chunks = 0, bytes = 0;
      for (const PlainLayer& each : plain) {
        count += each.records().size();
        chunks += each.chunks();
        bytes += each.payload_bytes();
      }
      REQUIRE(store.record_count() == count);
      REQUIRE(store.payload_bytes() == bytes);
      const std::size_t freed = of.has(key) ? chunks_of(of.records().at(key).payload.size()) : 0;
      const bool is_full =
          (!of.has(key) && count == kRecords) || chunks - freed + chunks_of(record.payload.size()) > kChunks;
      const Put expected = of.is_superseded(key, version)      ? Put::superseded
                           : of.is_taken(record.lane, version) ? Put::conflicting
                           : is_full                           ? Put::refused
                                                               : Put::stored;
      const std::uint64_t digest = store.digest(), content_hash = store.content_hash(layer), refused = store.refused();
      REQUIRE(store.put(layer, key, version, record.lane, record.payload) == expected);
      ++outcomes[static_cast<std::size_t>(expected)];
      if (expected == Put::stored) {
        of.put(key, record);
      } else {
        REQUIRE(store.digest() == digest);
        REQUIRE(store.content_hash(layer) == content_hash);
        REQUIRE(store.record_count() == count);
      }
      REQUIRE(store.refused() == refused + (expected == Put::refused ? 1 : 0));
      const auto found = store.find_record(layer, key);
      REQUIRE(found.has_value() == of.has(key));
      if (found) REQUIRE(found->version == of.version_of(key));
      if (step % 100 == 0) {
        for (LayerIndex l = 0; l < 3; ++l) check_lanes_are_the_same(store, l, plain[l]);
      }
    }
    for (LayerIndex l = 0; l < 3; ++l) check_lanes_are_the_same(store, l, plain[l]);
    for (const int outcome : outcomes) CHECK(outcome > 20);
  }
}

TEST_CASE("stores that got the same records in any order, some of them twice, are equal", "[net]") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    INFO("seed " << seed);
    tests::Random random(seed);
    const std::vector<OfferedRecord> published = published_records(random, 400);
    LayerStore first({3, 1000, 100000});
    for (const OfferedRecord& record : published) put_into(first, record);
    for (int order = 0; order < 3; ++order) {
      std::vector<OfferedRecord> arriving = published;
      for (int i = 0; i < 100; ++i) arriving.push_back(published[random.below(400)]);
      for (std::uint32_t i = static_cast<std::uint32_t>(arriving.size()); i > 1; --i) {
        std::swap(arriving[i - 1], arriving[random.below(i)]);
      }
      LayerStore other({3, 1000, 100000});
      for (const OfferedRecord& record : arriving) put_into(other, record);
      REQUIRE(other.digest() == first.digest());
      REQUIRE(other.record_count() == first.record_count());
      REQUIRE(other.payload_bytes() == first.payload_bytes());
      for (std::uint64_t robot = 1; robot <= 3; ++robot) {
        const LayerIndex here = first.find({robot, 1}), there = other.find({robot, 1});
        REQUIRE(other.content_hash(there) == first.content_hash(here));
        const std::map<RecordKey, Version> standing = standing_of(published, robot);
        std::map<RecordKey, Version> walked;
        for (const Lane lane : net::kAllLanes) {
          Version at = 0;
          while (const auto record = first.first_after(here, lane, at)) {
            const auto same = other.first_after(there, lane, at);
            REQUIRE(same);
            REQUIRE(same->key == record->key);
            REQUIRE(same->version == record->version);
            REQUIRE(payload_in(other, *same) == payload_in(first, *record));
            REQUIRE(walked.emplace(record->key, record->version).second);
            at = record->version;
          }
          REQUIRE_FALSE(other.first_after(there, lane, at));
        }
        REQUIRE(walked == standing);
      }
    }
  }
}

TEST_CASE("a whole block takes the place of older halves, and two newer halves that of the whole", "[net]") {
  LayerStore store({2, 100, 10000});
  const LayerIndex layer = store.find_or_add({1, 1});
  const RecordKey whole = net::block_record(2, 77, Part::whole);
  const RecordKey low = net::with_part(whole, Part::low_half), high = net::with_part(whole, Part::high_half);
  const auto put = [&](RecordKey key, Version version) {
    return store.put(layer, key, version, Lane::ground, Bytes{1});
  };
  const auto standing = [&] {
    std::vector<RecordKey> keys;
    for (const RecordKey key : {whole, low, high}) {
      if (store.find_record(layer, key)) keys.push_back(key);
    }
    return keys;
  };
  REQUIRE(put(low, 1) == Put::stored);
  REQUIRE(put(net::with_part(net::block_record(2, 78, Part::whole), Part::low_half), 2) == Put::stored);
  REQUIRE(put(whole, 5) == Put::stored);
  CHECK(standing() == std::vector{whole});
  CHECK(put(high, 4) == Put::superseded);
  REQUIRE(put(high, 9) == Put::stored);
  CHECK(standing() == std::vector{whole, high});  // of the whole one the low half still counts
  REQUIRE(put(whole, 7) == Put::stored);
  CHECK(standing() == std::vector{whole, high});
  REQUIRE(put(low, 8) == Put::stored);
  CHECK(standing() == std::vector{low, high});
  CHECK(put(whole, 6) == Put::superseded);
  CHECK(store.record_count() == 3);  // the neighbour's half was left alone
}

TEST_CASE("one version of a lane names one record, and versions begin with one", "[net]") {
  LayerStore store({2, 100, 10000});
  const LayerIndex layer = store.find_or_add({1, 1}), other = store.find_or_add({2, 1});
  REQUIRE(store.put(layer, net::status_record(1), 5, Lane::ground, {}) == Put::stored);
  CHECK(store.put(layer, net::status_record(2), 5, Lane::ground, {}) == Put::conflicting);
  CHECK(store.put(layer, net::status_record(1), 5, Lane::ground, {}) == Put::superseded);
  CHECK(store.put(layer, net::status_record(2), 5, Lane::rest, {}) == Put::stored);
  CHECK(store.put(other, net::status_record(2), 5, Lane::ground, {}) == Put::stored);
  CHECK(store.put(layer, net::status_record(3), 0, Lane::ground, {}) != Put::stored);
  CHECK(store.record_count() == 3);
  // A record that changes its lane leaves the old one.
  REQUIRE(store.put(layer, net::status_record(1), 6, Lane::frontier, {}) == Put::stored);
  CHECK_FALSE(store.first_after(layer, Lane::ground, 0));
  CHECK(store.first_after(layer, Lane::frontier, 0)->version == 6);
  CHECK(store.put(layer, net::status_record(2), 7, Lane::ground, {}) == Put::stored);
  CHECK(store.put(layer, net::status_record(4), 5, Lane::ground, {}) == Put::stored);
}

TEST_CASE("there is room for as many layers as were asked for", "[net]") {
  LayerStore store({3, 10, 1000});
  CHECK(store.most_layers() == 3);
  CHECK(store.find({1, 1}) == net::kNoLayer);
  CHECK(store.find_or_add({1, 1}) == 0);
  CHECK(store.find_or_add({1, 2}) == 1);  // another start of the same robot
  CHECK(store.find_or_add({2, 1}) == 2);
  CHECK(store.find_or_add({3, 1}) == net::kNoLayer);
  CHECK(store.find({3, 1}) == net::kNoLayer);
  CHECK(store.find_or_add({1, 2}) == 1);
  CHECK(store.layer_count() == 3);
  CHECK(store.id(2) == net::LayerId{2, 1});
  CHECK(store.digest() == 0);  // layers without records are as good as none
}

TEST_CASE("digests tell apart who wrote what in which version, but not how layers are numbered", "[net]") {
  const auto digest_of = [](std::vector<net::LayerId> ids, RecordKey key, Version version) {
    LayerStore store({4, 10, 1000});
    for (const net::LayerId& id : ids) (void)store.find_or_add(id);
    (void)store.put(store.find({1, 1}), key, version, Lane::rest, Bytes{1, 2});
    (void)store.put(store.find({2, 1}), net::status_record(9), 3, Lane::rest, Bytes{3});
    return store.digest();
  };
  const std::uint64_t digest = digest_of({{1, 1}, {2, 1}}, net::status_record(1), 1);
  CHECK(digest == digest_of({{2, 1}, {7, 7}, {1, 1}}, net::status_record(1), 1));
  CHECK(digest != digest_of({{1, 1}, {2, 1}}, net::status_record(2), 1));
  CHECK(digest != digest_of({{1, 1}, {2, 1}}, net::status_record(1), 2));
  CHECK(digest != digest_of({{1, 1}, {2, 1}}, net::status_record(9), 3));
}

TEST_CASE("what is had of a layer is what was added lane by lane, not what records there are", "[net]") {
  LayerStore store({2, 10, 1000});
  const LayerIndex layer = store.find_or_add({1, 1}), other = store.find_or_add({2, 1});
  REQUIRE(store.put(layer, net::status_record(1), 40, Lane::ground, {}) == Put::stored);
  CHECK(store.highest(layer) == 0);
  REQUIRE(store.add_had(layer, Lane::ground, {0, 10}));
  REQUIRE(store.add_had(layer, Lane::rest, {0, 4}));
  REQUIRE(store.add_had(layer, Lane::rest, {8, 12}));
  CHECK(store.upto(layer) == net::LaneVersions{10, 0, 4});
  CHECK(store.highest(layer) == 12);
  CHECK(store.had(layer, Lane::rest).covers({8, 12}));
  CHECK(store.had(layer, Lane::frontier) == net::VersionRanges());
  CHECK(store.upto(other) == net::LaneVersions{});
  CHECK_FALSE(store.is_unclaimed(layer));
  store.set_unclaimed(layer, true);
  CHECK(store.is_unclaimed(layer));
  CHECK_FALSE(store.is_unclaimed(other));
  store.set_unclaimed(layer, false);
  CHECK_FALSE(store.is_unclaimed(layer));
  for (Version v = 20; v < 20 + 2 * (net::VersionRanges::kMostBeyond - 1); v += 2) {
    REQUIRE(store.add_had(layer, Lane::rest, {v, v + 1}));
  }
  const net::VersionRanges full = store.had(layer, Lane::rest);
  CHECK_FALSE(store.add_had(layer, Lane::rest, {100, 101}));
  CHECK(store.had(layer, Lane::rest) == full);
}

TEST_CASE("changes are told once, all that were stored; when there were too many, all that stand", "[net]") {
  net::StoreLimits limits{2, 200, 10000};
  limits.changes = 20;
  LayerStore store(limits);
  const LayerIndex layer = store.find_or_add({1, 1}), other = store.find_or_add({2, 1});
  using Changes = std::set<std::pair<LayerIndex, RecordKey>>;
  const auto taken = [&] {
    Changes changes;
    store.take_changes([&](LayerIndex of, RecordKey key) { changes.emplace(of, key); });
    return changes;
  };
  CHECK(taken().empty());
  for (Version v = 1; v <= 3; ++v) {
    REQUIRE(store.put(layer, net::status_record(7), v, Lane::rest, {}) == Put::stored);
  }
  REQUIRE(store.put(other, net::status_record(8), 1, Lane::rest, {}) == Put::stored);
  REQUIRE(store.put(other, net::status_record(8), 1, Lane::rest, {}) == Put::superseded);
  REQUIRE(store.put(other, net::status_record(9), 1, Lane::rest, {}) == Put::conflicting);
  CHECK(taken() == Changes{{layer, net::status_record(7)}, {other, net::status_record(8)}});
  CHECK(taken().empty());
  Changes all{{layer, net::status_record(7)}, {other, net::status_record(8)}};
  for (std::uint32_t i = 0; i < 50; ++i) {
    REQUIRE(store.put(layer, net::pose_record(i), 10 + i, Lane::ground, {}) == Put::stored);
    all.emplace(layer, net::pose_record(i));
  }
  CHECK(taken() == all);
  CHECK(taken().empty());
  REQUIRE(store.put(layer, net::pose_record(5), 100, Lane::ground, {}) == Put::stored);
  CHECK(taken() == Changes{{layer, net::pose_record(5)}});
}

TEST_CASE("a full store takes an update that is no longer than what it replaces", "[net]") {
  LayerStore store({2, 4, 4 * 36});
  const LayerIndex layer = store.find_or_add({1, 1});
  for (std::uint32_t block = 0; block < 4; ++block) {
    REQUIRE(store.put(layer, net::block_record(0, block, Part::whole), block + 1, Lane::rest, Bytes(28, 1)) ==
            Put::stored);
  }
  REQUIRE(store.put(layer, net::block_record(0, 9, Part::whole), 9, Lane::rest, Bytes{1}) == Put::refused);
  CHECK(store.put(layer, net::block_record(0, 2, Part::whole), 10, Lane::ground, Bytes(28, 2)) == Put::stored);
  CHECK(store.put(layer, net::block_record(0, 3, Part::whole), 11, Lane::rest, Bytes(3, 3)) == Put::stored);
  const std::uint64_t digest = store.digest();
  CHECK(store.put(layer, net::block_record(0, 1, Part::whole), 12, Lane::rest, Bytes(29, 4)) == Put::refused);
  CHECK(store.digest() == digest);
  CHECK(payload_in(store, *store.find_record(layer, net::block_record(0, 1, Part::whole))) == Bytes(28, 1));
  CHECK(payload_in(store, *store.find_record(layer, net::block_record(0, 2, Part::whole))) == Bytes(28, 2));
}
