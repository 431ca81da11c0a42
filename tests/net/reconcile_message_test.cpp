// SPDX-License-Identifier: Apache-2.0
#include "net/reconcile_message.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using net::MessageFault;

namespace {

const net::LayerId kAskedLayer{77, 3};
const net::SketchSalt kAskedSalt{5, 6};

mapper::Bytes copy_of(const net::WireWriter& out) { return {out.bytes().begin(), out.bytes().end()}; }

/// Every cut of a message and every flipped byte is a fault or another valid message.
template <typename Read>
void check_hostile(const mapper::Bytes& message, Read&& read) {
  for (std::size_t bytes = 0; bytes < message.size(); ++bytes) (void)read(mapper::ByteSpan(message).first(bytes));
  CHECK(read(mapper::ByteSpan(message).first(1)) != MessageFault::none);
  mapper::Bytes flipped = message;
  for (std::size_t i = 0; i < message.size(); ++i) {
    for (const std::uint8_t mask : {0x01, 0x80, 0xFF}) {
      flipped[i] = static_cast<std::uint8_t>(message[i] ^ mask);
      (void)read(flipped);
    }
    flipped[i] = message[i];
  }
  flipped[0] = 99;
  CHECK(read(flipped) == MessageFault::unknown_kind);
}

}  // namespace

TEST_CASE("an ask for symbols is read as it was written", "[net][reconcile]") {
  net::WireWriter out;
  net::write_sketch_ask(out, {kAskedLayer, kAskedSalt, 1000, 64});
  net::SketchAsk ask;
  REQUIRE(net::read_sketch_ask(out.bytes(), ask) == MessageFault::none);
  CHECK(ask.layer == kAskedLayer);
  CHECK(ask.salt == kAskedSalt);
  CHECK(ask.first == 1000);
  CHECK(ask.count == 64);
  check_hostile(copy_of(out), [&](mapper::ByteSpan bytes) { return net::read_sketch_ask(bytes, ask); });
  net::write_sketch_ask(out, {kAskedLayer, kAskedSalt, 1000, 0});
  CHECK(net::read_sketch_ask(out.bytes(), ask) == MessageFault::bad_range);
  net::write_sketch_ask(out, {kAskedLayer, kAskedSalt, net::kMostSketchSymbols, 1});
  CHECK(net::read_sketch_ask(out.bytes(), ask) == MessageFault::bad_range);
}

TEST_CASE("symbols travel with what the sender has", "[net][reconcile]") {
  std::vector<net::SketchSymbol> symbols(64);
  net::SketchEncoder encoder(kAskedSalt, 16, symbols);
  for (std::uint64_t i = 0; i < 500; ++i) encoder.add(net::sketch_id(kAskedSalt, i, i + 1));
  net::LayerPosition position{kAskedLayer, {net::VersionRanges(10), net::VersionRanges(20), net::VersionRanges(30)}};
  REQUIRE(position.had[1].add({25, 28}));
  net::WireWriter out;
  REQUIRE(net::write_sketch_answer(out, position, 4711, {kAskedSalt, 16, 500}, symbols) == symbols.size());
  net::SketchAnswer answer;
  REQUIRE(net::read_sketch_answer(out.bytes(), answer) == MessageFault::none);
  CHECK(answer.position.id == kAskedLayer);
  CHECK(answer.position.had == position.had);
  CHECK(answer.content_hash == 4711);
  CHECK(answer.sketch.header.first == 16);
  CHECK(std::vector(answer.sketch.used().begin(), answer.sketch.used().end()) == symbols);
  check_hostile(copy_of(out), [&](mapper::ByteSpan bytes) { return net::read_sketch_answer(bytes, answer); });
}

TEST_CASE("ids are asked for as far as they fit", "[net][reconcile]") {
  std::vector<net::SketchId> ids(300);
  tests::Random random(1);
  for (net::SketchId& id : ids) id = random.next();
  net::WireWriter out;
  net::write_id_ask(out, kAskedLayer, kAskedSalt, ids);
  CHECK(out.size() <= net::kMostMessage_bytes);
  net::IdAsk ask;
  REQUIRE(net::read_id_ask(out.bytes(), ask) == MessageFault::none);
  CHECK(ask.count == net::kMostIdsPerMessage);
  CHECK(std::equal(ask.all().begin(), ask.all().end(), ids.begin()));
  check_hostile(copy_of(out), [&](mapper::ByteSpan bytes) { return net::read_id_ask(bytes, ask); });
}

TEST_CASE("loose records are read as they were written", "[net][reconcile]") {
  net::LayerStore store({2, 64, 1U << 16});
  const net::LayerIndex layer = store.find_or_add(kAskedLayer);
  tests::Random random(2);
  for (net::Version version = 1; version <= 20; ++version) {
    mapper::Bytes payload(random.below(60), static_cast<std::uint8_t>(version));
    REQUIRE(store.put(layer, net::block_record(1, random.below(1U << 30), net::Part::whole), 7 * version,
                      static_cast<net::Lane>(random.below(3)), payload) == net::LayerStore::Put::stored);
  }
  net::WireWriter out;
  net::begin_records(out, kAskedLayer);
  net::RecordKey last_key = 0;
  std::vector<net::StoredRecord> written;
  store.for_each(layer, [&](const net::StoredRecord& record) {
    REQUIRE(net::add_loose_record(out, store, record, last_key));
    written.push_back(record);
  });
  net::LooseRecords records;
  REQUIRE(records.open(out.bytes()) == MessageFault::none);
  CHECK(records.layer() == kAskedLayer);
  std::size_t count = 0;
  for (net::LooseRecord record; records.take(record); ++count) {
    REQUIRE(count < written.size());
    CHECK(record.key == written[count].key);
    CHECK(record.version == written[count].version);
    CHECK(record.lane == written[count].lane);
    CHECK(store.holds(written[count], record.payload));
  }
  CHECK(count == written.size());
  check_hostile(copy_of(out), [](mapper::ByteSpan bytes) { return net::LooseRecords().open(bytes); });
}
