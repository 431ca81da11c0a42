// SPDX-License-Identifier: Apache-2.0
#include "net/journal_restore.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <map>
#include <vector>

#include "net/journal_frame.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using mapper::Bytes;
using net::Lane;
using net::LayerIndex;
using net::LayerStore;
using net::Version;

namespace {

struct PublishedRecord {
  net::LayerId layer;
  net::RecordKey key = 0;
  Version version = 0;
  Lane lane = Lane::rest;
};

/// Two layers of chance in frames of a few entries, each with a claim now and then; what was put into each frame.
struct SampleJournal {
  explicit SampleJournal(std::uint64_t seed) {
    tests::Random random(seed);
    std::map<net::LayerId, Version> versions;
    file.assign(net::kJournalMark.begin(), net::kJournalMark.end());
    for (int frame = 0; frame < 12; ++frame) {
      Bytes entries;
      for (int i = 0; i < 4; ++i) {
        const net::LayerId id{1 + random.below(2), 5};
        net::StoredRecord record;
        record.key = net::block_record(0, random.below(8), net::Part::whole);
        record.version = ++versions[id];
        record.lane = static_cast<Lane>(random.below(3));
        net::add_layer_entry(entries, id);
        net::add_record_entry(entries, record, Bytes(random.below(9), static_cast<std::uint8_t>(record.version)));
        published.push_back({id, record.key, record.version, record.lane});
        if (random.below(3) != 0) continue;
        net::LayerPosition position{id, {}};
        for (net::VersionRanges& had : position.had) (void)had.add(net::VersionRange{0, record.version});
        net::add_claim_entry(entries, position, false);
      }
      net::add_frame(file, entries);
      frame_ends.push_back(file.size());
      records_by_frame.push_back(published.size());
    }
  }
  Bytes file;
  std::vector<std::size_t> frame_ends;
  std::vector<std::size_t> records_by_frame;
  std::vector<PublishedRecord> published;
};

/// All that a layer claims to have is there, or something newer in its place.
void check_claims(const LayerStore& store, const SampleJournal& journal) {
  for (const PublishedRecord& record : journal.published) {
    const LayerIndex layer = store.find(record.layer);
    if (layer == net::kNoLayer || store.had(layer, record.lane).upto() < record.version) continue;
    const auto found = store.find_record(layer, record.key);
    REQUIRE(found);
    CHECK(found->version >= record.version);
  }
}

}  // namespace

TEST_CASE("a journal that was cut anywhere restores what was written before, and claims no more", "[net]") {
  const test::TempFolder folder;
  const SampleJournal journal(3);
  for (std::size_t size = net::kJournalMark.size(); size <= journal.file.size(); ++size) {
    test::write_plain(folder / "j", mapper::ByteSpan(journal.file).first(size));
    LayerStore store({4, 100, 10000});
    const auto restored = net::restore_layers(folder / "j", store);
    REQUIRE(restored.ok());
    const auto frames = static_cast<std::size_t>(
        std::upper_bound(journal.frame_ends.begin(), journal.frame_ends.end(), size) - journal.frame_ends.begin());
    CHECK(restored.value().counts.frames == frames);
    CHECK_FALSE(restored.value().is_damaged());
    CHECK(restored.value().good_bytes + restored.value().counts.cut_bytes == size);
    // Exactly what a store has that was given the records of those frames.
    LayerStore plain({4, 100, 10000});
    for (std::size_t i = 0; i < (frames == 0 ? 0 : journal.records_by_frame[frames - 1]); ++i) {
      const PublishedRecord& record = journal.published[i];
      (void)plain.put(plain.find_or_add(record.layer), record.key, record.version, record.lane, {});
    }
    CHECK(store.digest() == plain.digest());
    check_claims(store, journal);
  }
}

TEST_CASE("damage in the middle costs its frame, and claims end there", "[net]") {
  const test::TempFolder folder;
  const SampleJournal journal(4);
  LayerStore whole({4, 100, 10000});
  test::write_plain(folder / "j", journal.file);
  REQUIRE(net::restore_layers(folder / "j", whole).ok());
  int unclaimed = 0;
  for (std::size_t at = net::kJournalMark.size(); at < journal.file.size(); at += 3) {
    Bytes wrong = journal.file;
    wrong[at] ^= 0x10;
    test::write_plain(folder / "j", wrong);
    LayerStore store({4, 100, 10000});
    const auto restored = net::restore_layers(folder / "j", store);
    REQUIRE(restored.ok());
    check_claims(store, journal);
    for (LayerIndex layer = 0; layer < store.layer_count(); ++layer) {
      if (!store.is_unclaimed(layer)) continue;
      ++unclaimed;
      CHECK(restored.value().is_damaged());
      const LayerIndex same = whole.find(store.id(layer));
      CHECK(store.highest(layer) <= whole.highest(same));
    }
  }
  CHECK(unclaimed > 50);
}

TEST_CASE("a store that is too small for a journal, or refuses a robot, claims nothing of what it lacks", "[net]") {
  const test::TempFolder folder;
  const SampleJournal journal(5);
  test::write_plain(folder / "j", journal.file);
  LayerStore small({4, 9, 10000});
  auto restored = net::restore_layers(folder / "j", small);
  REQUIRE(restored.ok());
  CHECK(restored.value().counts.refused_records > 0);
  bool is_unclaimed = false;
  for (LayerIndex layer = 0; layer < small.layer_count(); ++layer) is_unclaimed |= small.is_unclaimed(layer);
  CHECK(is_unclaimed);
  check_claims(small, journal);

  LayerStore without({4, 100, 10000});
  REQUIRE(without.refuse_robot(2));
  restored = net::restore_layers(folder / "j", without);
  REQUIRE(restored.ok());
  CHECK(without.layer_count() == 1);
  CHECK(without.find({2, 5}) == net::kNoLayer);
  check_claims(without, journal);

  // A frame that is whole and says nothing that can be is passed over like a damaged one.
  Bytes strange = journal.file;
  net::add_frame(strange, Bytes{9, 9, 9});
  test::write_plain(folder / "j", strange);
  LayerStore store({4, 100, 10000});
  restored = net::restore_layers(folder / "j", store);
  REQUIRE(restored.ok());
  CHECK(restored.value().counts.bad_entries == 1);
  CHECK(restored.value().is_damaged());
}
