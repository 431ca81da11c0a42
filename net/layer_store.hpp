// SPDX-License-Identifier: Apache-2.0
// All that a robot holds of the shared map, its own layer and others': of every record the newest version, as the bytes
// that travel. Who has the same versions of a layer holds the same records, wherever they came from.
//
// A layer has three lanes, and within each its records stand in the order of their versions. Who is behind gets the
// first lane first: the ground band, in which robots drive, then where known space ends, then the rest. A record that
// changes its lane counts by its version alone.
//
// A robot in wrong hands may have its layers refused: they vanish at once for whoever asks, and nobody brings them
// back; the room that they took comes back bit by bit.
//
// Memory is sized at construction. A record for which there is no room is refused and not counted as had. One thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapper/fixed_table.hpp"
#include "net/layer_id.hpp"
#include "net/payload_chunks.hpp"
#include "net/record_key.hpp"
#include "net/version_ranges.hpp"
#include "net/version_tree.hpp"

namespace g3d::net {

enum class Lane : std::uint8_t { ground, frontier, rest };
inline constexpr int kLanes = 3;
inline constexpr std::array<Lane, kLanes> kAllLanes{Lane::ground, Lane::frontier, Lane::rest};

using LaneVersions = std::array<Version, kLanes>;

/// Place of a layer in a store.
using LayerIndex = std::uint32_t;
inline constexpr LayerIndex kNoLayer = 0xFFFFFFFFU;

struct StoreLimits {
  std::uint32_t layers = 64;         ///< at most 511
  std::uint32_t records = 1U << 18;  ///< 64 bytes each, with their place in the table
  std::size_t payload_bytes = std::size_t{32} << 20;
  std::uint32_t changes = 1U << 14;  ///< remembered for take_changes()
};

struct StoredRecord {
  RecordKey key = 0;
  Version version = 0;
  Lane lane = Lane::rest;
  std::uint16_t bytes = 0;
  std::uint32_t slot = 0;
};

/// Is told of all that changes in a store, as it happens, by the store's thread.
class StoreWatch {
 public:
  virtual ~StoreWatch() = default;
  virtual void on_record(LayerIndex layer, const StoredRecord& record, mapper::ByteSpan payload) = 0;
  /// What is had of a layer, or whether it is claimed.
  virtual void on_claim(LayerIndex layer) = 0;
  virtual void on_refused_robot(RobotId robot) = 0;
};

class LayerStore {
 public:
  static constexpr std::size_t kMostRefusedRobots = 256;

  enum class Put : std::uint8_t {
    stored,
    superseded,   ///< it holds that version or a newer one already
    refused,      ///< there is no room
    conflicting,  ///< the lane has another record of that version: no honest writer does that
  };

  explicit LayerStore(const StoreLimits& limits = {});

  [[nodiscard]] LayerIndex find(const LayerId& id) const;
  [[nodiscard]] LayerIndex find(LayerAlias alias) const;
  /// kNoLayer if it is new and there is no room, or of a robot that is refused, or another one has its short name: one
  /// of some millions of pairs.
  [[nodiscard]] LayerIndex find_or_add(const LayerId& id);
  [[nodiscard]] std::uint32_t layer_count() const { return static_cast<std::uint32_t>(layers_.size()); }
  [[nodiscard]] std::uint32_t most_layers() const { return static_cast<std::uint32_t>(layers_.capacity()); }
  [[nodiscard]] const LayerId& id(LayerIndex layer) const { return layers_[layer].id; }

  /// `payload`: at most 65535 bytes. A record takes the room of the one of the same key whose place it takes: what is
  /// no longer than before always finds room.
  Put put(LayerIndex layer, RecordKey key, Version version, Lane lane, mapper::ByteSpan payload);
  [[nodiscard]] std::optional<StoredRecord> find_record(LayerIndex layer, RecordKey key) const;
  /// The record of the lane with the lowest version above `version`.
  [[nodiscard]] std::optional<StoredRecord> first_after(LayerIndex layer, Lane lane, Version version) const;
  /// All records of a layer, lane by lane in order of version.
  template <typename Visit>
  void for_each(LayerIndex layer, Visit&& visit) const {
    for (const Lane lane : kAllLanes) {
      for (auto record = first_after(layer, lane, 0); record; record = first_after(layer, lane, record->version)) {
        visit(*record);
      }
    }
  }
  /// `out`: as long as the record.
  void read(const StoredRecord& record, std::span<std::uint8_t> out) const {
    chunks_.get(records_[record.slot].chain, out);
  }

  [[nodiscard]] bool holds(const StoredRecord& record, mapper::ByteSpan payload) const {
    return record.bytes == payload.size() && chunks_.equals(records_[record.slot].chain, payload);
  }

  /// visit(layer, key) for every record that was stored since the last time, some more than once; for one reader. If
  /// there were more than can be remembered, for all. Of a layer that was refused meanwhile a single key, which it does
  /// not hold: see is_refused().
  template <typename Visit>
  void take_changes(Visit&& visit) {
    if (changes_.size() < changes_.capacity()) {
      for (const Change& change : changes_) visit(change.layer, change.key);
    } else {
      for (LayerIndex layer = 0; layer < layer_count(); ++layer) {
        if (is_refused(layer)) visit(layer, pose_record(0));
        for_each(layer, [&](const StoredRecord& record) { visit(layer, record.key); });
      }
    }
    changes_.clear();
  }

  /// What it has of a lane. Whoever puts records says what is complete by them.
  [[nodiscard]] const VersionRanges& had(LayerIndex layer, Lane lane) const {
    return layers_[layer].had[static_cast<std::size_t>(lane)];
  }
  [[nodiscard]] LaneVersions upto(LayerIndex layer) const;
  /// The highest version of what is had, gaps before it or not.
  [[nodiscard]] Version highest(LayerIndex layer) const;
  bool add_had(LayerIndex layer, Lane lane, const VersionRange& range);

  /// Of a layer whose records were kept and what they complete was lost, as by a restart: it is not asked for from the
  /// start, but compared with another robot's first.
  void set_unclaimed(LayerIndex layer, bool is_unclaimed);
  [[nodiscard]] bool is_unclaimed(LayerIndex layer) const { return layers_[layer].is_unclaimed; }

  /// Nobody's records of this robot's layers are taken from now on, and what is held of them is gone. Their places stay
  /// taken, their indices valid. Takes as long as there are layers; drop_some() does the rest. False if there are
  /// kMostRefusedRobots already.
  bool refuse_robot(RobotId robot);
  [[nodiscard]] bool is_refused_robot(RobotId robot) const;
  [[nodiscard]] bool is_refused(LayerIndex layer) const { return layers_[layer].is_refused; }
  [[nodiscard]] std::span<const RobotId> refused_robots() const { return refused_robots_; }
  /// Gives back the room of at most so many records of refused layers. False if none is left.
  bool drop_some(std::uint32_t most_records);

  /// Told from now on; nullptr: nobody.
  void set_watch(StoreWatch* watch) { watch_ = watch; }

  /// Of the keys and versions of all records: equal for those who hold the same, in whatever order they came.
  [[nodiscard]] std::uint64_t digest() const;
  /// The same of one layer.
  [[nodiscard]] std::uint64_t content_hash(LayerIndex layer) const { return layers_[layer].content_hash; }
  [[nodiscard]] std::uint32_t record_count(LayerIndex layer) const { return layers_[layer].record_count; }
  [[nodiscard]] std::uint32_t record_count() const { return records_.in_use(); }
  /// Of refused layers as well, until they are dropped.
  [[nodiscard]] std::size_t payload_bytes() const { return payload_bytes_; }
  [[nodiscard]] std::uint64_t refused() const { return refused_; }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  struct Record {
    TreeNode node;
    RecordKey key;
    std::uint32_t chain;
    std::uint16_t bytes;
    Lane lane;
  };
  struct Layer {
    LayerId id;
    std::array<std::uint32_t, kLanes> roots{kNone, kNone, kNone};
    std::array<VersionRanges, kLanes> had{};
    std::uint64_t content_hash = 0;
    std::uint32_t record_count = 0;
    bool is_unclaimed = false;
    bool is_refused = false;
    std::array<std::uint32_t, kLanes> dropped_roots{kNone, kNone, kNone};  ///< of what drop_some() is to give back
  };
  struct Change {
    LayerIndex layer;
    RecordKey key;
  };
  struct Nodes {
    mapper::SlotPool<Record>& records;
    [[nodiscard]] TreeNode& operator()(std::uint32_t slot) const { return records[slot].node; }
  };
  using Tree = VersionTree<Nodes>;

  [[nodiscard]] static std::uint64_t table_key(LayerIndex layer, RecordKey key) {
    return (std::uint64_t{layer} << kRecordKeyBits) | key;
  }
  [[nodiscard]] std::uint32_t slot_of(LayerIndex layer, RecordKey key) const;
  [[nodiscard]] Version version_of(LayerIndex layer, RecordKey key) const;
  [[nodiscard]] bool is_superseded(LayerIndex layer, RecordKey key, Version version) const;
  void drop_superseded(LayerIndex layer, RecordKey key);
  void erase(LayerIndex layer, RecordKey key);
  void give_back(LayerIndex layer, std::uint32_t slot);
  [[nodiscard]] StoredRecord stored(std::uint32_t slot) const;

  std::vector<Layer> layers_;        ///< reserved: never moves
  std::vector<LayerAlias> aliases_;  ///< of each layer; reserved
  mutable mapper::SlotPool<Record> records_;
  mapper::FixedTable<std::uint32_t> table_;
  PayloadChunks chunks_;
  std::vector<Change> changes_;          ///< reserved; full: more than it holds
  std::vector<RobotId> refused_robots_;  ///< reserved
  StoreWatch* watch_ = nullptr;
  std::size_t payload_bytes_ = 0;
  std::uint64_t refused_ = 0;
};

}  // namespace g3d::net
