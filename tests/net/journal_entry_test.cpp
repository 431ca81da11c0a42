// SPDX-License-Identifier: Apache-2.0
#include "net/journal_entry.hpp"

#include <catch2/catch.hpp>
#include <vector>

using namespace g3d;
using mapper::Bytes;
using net::EntryFault;
using net::Lane;
using net::Part;

namespace {

struct ReadEntries final : net::JournalVisitor {
  void on_record(const net::JournalRecord& record) override {
    records.push_back(record);
    payloads.emplace_back(record.payload.begin(), record.payload.end());
  }
  void on_claim(const net::LayerPosition& position, bool is_unclaimed) override {
    claims.emplace_back(position, is_unclaimed);
  }
  std::vector<net::JournalRecord> records;
  std::vector<Bytes> payloads;
  std::vector<std::pair<net::LayerPosition, bool>> claims;
};

net::StoredRecord journal_record(net::RecordKey key, net::Version version, Lane lane) {
  net::StoredRecord record;
  record.key = key;
  record.version = version;
  record.lane = lane;
  return record;
}

Bytes sample_entries() {
  Bytes out;
  net::add_layer_entry(out, {7, 9});
  net::add_record_entry(out, journal_record(net::block_record(3, 77, Part::low_half), 1000, Lane::frontier),
                        Bytes{1, 2, 3});
  net::add_record_entry(out, journal_record(net::pose_record(3), net::kMostVersion, Lane::ground),
                        Bytes(net::kMostPayload_bytes, 5));
  net::LayerPosition position{{8, 1}, {}};
  (void)position.had[0].add(net::VersionRange{0, 50});
  (void)position.had[2].add(net::VersionRange{60, 70});
  net::add_claim_entry(out, position, true);
  net::add_layer_entry(out, {8, 1});
  net::add_record_entry(out, journal_record(net::status_record(1), 1, Lane::rest), {});
  return out;
}

}  // namespace

TEST_CASE("entries of a journal are read as they were written", "[net]") {
  ReadEntries read;
  REQUIRE(net::read_entries(sample_entries(), &read) == EntryFault::none);
  REQUIRE(read.records.size() == 3);
  CHECK(read.records[0].layer == net::LayerId{7, 9});
  CHECK(read.records[0].key == net::block_record(3, 77, Part::low_half));
  CHECK(read.records[0].version == 1000);
  CHECK(read.records[0].lane == Lane::frontier);
  CHECK(read.payloads[0] == Bytes{1, 2, 3});
  CHECK(read.records[1].layer == net::LayerId{7, 9});
  CHECK(read.payloads[1] == Bytes(net::kMostPayload_bytes, 5));
  CHECK(read.records[2].layer == net::LayerId{8, 1});
  CHECK(read.payloads[2].empty());
  REQUIRE(read.claims.size() == 1);
  CHECK(read.claims[0].second);
  CHECK(read.claims[0].first.id == net::LayerId{8, 1});
  CHECK(read.claims[0].first.had[0].upto() == 50);
  CHECK(read.claims[0].first.had[2].beyond()[0] == net::VersionRange{60, 70});
  CHECK(net::read_entries({}, nullptr) == EntryFault::none);
}

TEST_CASE("entries that say nothing that can be are refused with the reason", "[net]") {
  const auto fault_of = [](const Bytes& entries) { return net::read_entries(entries, nullptr); };
  const Bytes whole = sample_entries();
  int truncated = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const EntryFault fault = net::read_entries(mapper::ByteSpan(whole).first(size), nullptr);
    REQUIRE((fault == EntryFault::none || fault == EntryFault::truncated));
    truncated += fault == EntryFault::truncated ? 1 : 0;
  }
  CHECK(truncated > 1000);
  CHECK(fault_of({0}) == EntryFault::unknown_kind);
  CHECK(fault_of({4}) == EntryFault::unknown_kind);
  Bytes out;
  net::add_record_entry(out, journal_record(net::pose_record(0), 1, Lane::rest), {});
  CHECK(fault_of(out) == EntryFault::no_layer);
  const auto with_layer = [&](const net::StoredRecord& record, std::size_t bytes) {
    Bytes entries;
    net::add_layer_entry(entries, {1, 1});
    net::add_record_entry(entries, record, Bytes(bytes));
    return fault_of(entries);
  };
  CHECK(with_layer(journal_record(net::pose_record(0), 1, Lane::rest), 0) == EntryFault::none);
  CHECK(with_layer(journal_record(net::pose_record(0), 0, Lane::rest), 0) == EntryFault::bad_record);
  CHECK(with_layer(journal_record(net::pose_record(0), net::kMostVersion + 1, Lane::rest), 0) ==
        EntryFault::bad_record);
  CHECK(with_layer(journal_record(3, 1, Lane::rest), 0) == EntryFault::bad_record);
  CHECK(with_layer(journal_record(net::pose_record(0), 1, static_cast<Lane>(3)), 0) == EntryFault::bad_record);
  CHECK(with_layer(journal_record(net::pose_record(0), 1, Lane::rest), net::kMostPayload_bytes + 1) ==
        EntryFault::bad_record);
  out.clear();
  net::add_claim_entry(out, {}, false);
  out[1] = 2;
  CHECK(fault_of(out) == EntryFault::bad_claim);
}
