// SPDX-License-Identifier: Apache-2.0
#include "net/journal_restore.hpp"

#include <vector>

#include "net/journal_frame.hpp"

namespace g3d::net {
namespace {

class Restoring final : public JournalVisitor {
 public:
  Restoring(LayerStore& store, RestoreCounts& counts)
      : store_(store), counts_(counts), has_lost_(store.most_layers(), false) {}

  void on_record(const JournalRecord& record) override {
    const LayerIndex layer = store_.find_or_add(record.layer);
    if (layer == kNoLayer) {
      ++counts_.refused_records;
      return;
    }
    if (is_damaged_) lose(layer);
    switch (store_.put(layer, record.key, record.version, record.lane, record.payload)) {
      case LayerStore::Put::stored:
        ++counts_.records;
        return;
      case LayerStore::Put::superseded:
        return;
      case LayerStore::Put::refused:
      case LayerStore::Put::conflicting:
        ++counts_.refused_records;
        lose(layer);
    }
  }
  void on_claim(const LayerPosition& position, bool is_unclaimed) override {
    const LayerIndex layer = store_.find_or_add(position.id);
    if (layer == kNoLayer || has_lost_[layer]) return;
    if (is_damaged_) return lose(layer);
    for (const Lane lane : kAllLanes) {
      const VersionRanges& had = position.had[static_cast<std::size_t>(lane)];
      (void)store_.add_had(layer, lane, {0, had.upto()});
      for (const VersionRange& range : had.beyond()) (void)store_.add_had(layer, lane, range);
    }
    store_.set_unclaimed(layer, is_unclaimed);
  }
  /// From here on something is missing before everything.
  void note_damage() { is_damaged_ = true; }

 private:
  void lose(LayerIndex layer) {
    has_lost_[layer] = true;
    store_.set_unclaimed(layer, true);
  }
  LayerStore& store_;
  RestoreCounts& counts_;
  std::vector<bool> has_lost_;  ///< by layer
  bool is_damaged_ = false;
};

}  // namespace

hal::Result<RestoredJournal> restore_layers(const std::string& path, LayerStore& store) {
  RestoredJournal restored;
  FrameReader reader;
  if (const auto opened = reader.open(path); !opened) return opened.error();
  Restoring restoring(store, restored.counts);
  for (;;) {
    auto next = reader.next();
    if (!next) return next.error();
    if (next.value() == FrameReader::Next::end) break;
    if (next.value() == FrameReader::Next::damaged) {
      ++restored.counts.damaged_places;
      restoring.note_damage();
      continue;
    }
    if (read_entries(reader.entries(), nullptr) != EntryFault::none) {
      ++restored.counts.bad_entries;
      restoring.note_damage();
      continue;
    }
    (void)read_entries(reader.entries(), &restoring);
    ++restored.counts.frames;
  }
  restored.good_bytes = reader.good_bytes();
  restored.counts.cut_bytes = reader.file_bytes() - reader.good_bytes();
  return restored;
}

}  // namespace g3d::net
