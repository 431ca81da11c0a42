// SPDX-License-Identifier: Apache-2.0
// What a robot knows of the shared map survives its restart: everything that changes in a store is written to a journal
// in a folder, and the next start finds it in the store again. Power cuts lose the last second at most.
//
//   store ─▶ on_record, on_claim ─▶ ring ─▶ thread of its own ─▶ layers.journal, identity
//
// The store's thread never waits for the disk. Where the ring is full or the disk refuses, nothing more is claimed to
// be complete, and as soon as that goes, a new journal is made of what the store holds, bit by bit. The same happens
// when the journal has become much longer than what stands of it. A robot whose disk is broken goes on; the next start
// then knows as much as was written, and others give it the rest.
//
// Versions of the own layer are reserved on disk before they are used (layer_identity.hpp). Who finds no reservation of
// its own begins a new incarnation.
//
// All calls from the store's thread. Nothing is allocated after open().
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "hal/messages.hpp"
#include "hal/parking.hpp"
#include "net/journal_restore.hpp"
#include "net/journal_writer.hpp"
#include "net/layer_store.hpp"

namespace g3d::net {

struct KeeperOptions {
  std::string folder;  ///< made if it is not there
  RobotId robot = 0;
  std::vector<RobotId> dropped;  ///< robots whose layers nobody keeps
  std::size_t ring_bytes = std::size_t{4} << 20;
  bool has_thread = true;  ///< false: the disk is waited for in on_time(), in tests and simulations
  hal::TimeNs flush_ns = 100'000'000;
  hal::TimeNs sync_ns = 800'000'000;
  hal::TimeNs again_ns = 1'000'000'000;  ///< after the disk refused
  Version reserve = Version{1} << 22;    ///< versions at a time
};

struct KeeperCounts {
  JournalCounts journal;
  std::uint64_t dropped_entries = 0;  ///< the ring was full
  std::uint64_t begun_journals = 0;
};

class LayerKeeper final : public StoreWatch {
 public:
  /// Fills `store`, which is empty and outlives this, and watches it from then on. What the disk refuses is no error,
  /// see trouble(). Errors: bad_usage, if this robot's own layers are dropped; no_permission, if another process has
  /// the folder.
  [[nodiscard]] static hal::Result<std::unique_ptr<LayerKeeper>> open(const KeeperOptions& options, LayerStore& store);
  /// What is in the ring is still written, if there is a thread.
  ~LayerKeeper() override;

  /// As whom to write, and where to go on: for GossipOptions::self and ::restored_upto.
  [[nodiscard]] const LayerId& self() const { return identity_.self; }
  [[nodiscard]] Version restored_upto() const { return restored_upto_; }
  /// The first submap of our own layer that no earlier start has written.
  [[nodiscard]] std::uint32_t first_submap() const { return first_submap_; }
  [[nodiscard]] const RestoreCounts& restored() const { return restored_; }

  /// Every 5 to 20 ms. `version`: the last that our own layer has used.
  void on_time(Version version, hal::TimeNs now_ns);
  /// For Gossip::set_version_limit().
  [[nodiscard]] Version version_limit() const;
  /// Writes what is left, and that no version above this was used. Waits for the disk; nothing is watched any more.
  void close(Version version);

  [[nodiscard]] KeeperCounts counts() const;
  /// Whether what is known now would be found after a restart, but for the last second.
  [[nodiscard]] bool is_durable() const { return !has_lost_ && !writer_.needs_new(); }
  /// The last thing that the disk refused, if anything.
  [[nodiscard]] std::optional<hal::Error> trouble() const;
  [[nodiscard]] const JournalWriter& writer() const { return writer_; }

 private:
  LayerKeeper(const KeeperOptions& options, LayerStore& store);
  [[nodiscard]] bool lock();
  void restore();
  void take_identity();
  std::uint32_t find_first_submap(const LayerId& self);
  void on_record(LayerIndex layer, const StoredRecord& record, mapper::ByteSpan payload) override;
  void on_claim(LayerIndex layer) override { claims_[layer] = true; }
  void on_refused_robot(RobotId) override { is_due_ = true; }
  void push(JournalCommand command);
  void push_record(JournalCommand command, LayerIndex layer, const StoredRecord& record, mapper::ByteSpan payload);
  void push_claim(JournalCommand command, LayerIndex layer);
  void push_claims();
  void reserve(Version version, hal::TimeNs now_ns);
  void begin_journal(hal::TimeNs now_ns);
  void add_to_journal();
  [[nodiscard]] bool add_records(LayerIndex layer);
  [[nodiscard]] bool journal_is_due(hal::TimeNs now_ns) const;
  void wake();

  KeeperOptions options_;
  LayerStore& store_;
  JournalWriter writer_;
  LayerIdentity identity_;  ///< with what was asked to be reserved last
  Version first_reserved_ = 0;
  Version restored_upto_ = 0;
  std::uint32_t first_submap_ = 0;
  RestoreCounts restored_;
  mapper::Bytes entry_;
  mapper::Bytes payload_;
  std::vector<bool> claims_;   ///< by layer: to be written
  bool has_lost_ = false;      ///< the journal lacks something: nothing may be claimed in it
  bool new_has_lost_ = false;  ///< the one that is being made
  bool is_due_ = false;        ///< a new journal, though the old one is good
  bool is_named_ = false;      ///< whether the disk had taken our identity when this began
  hal::TimeNs flushed_ns_ = 0;
  hal::TimeNs synced_ns_ = 0;
  hal::TimeNs reserved_ns_ = 0;
  hal::TimeNs begun_ns_ = 0;
  bool has_news_ = true;  ///< since the last sync

  /// The new journal that is being made: where in the store it stands.
  struct Walk {
    LayerIndex layer = 0;
    std::size_t lane = 0;
    Version version = 0;
  };
  std::optional<Walk> walk_;
  std::uint64_t begun_ = 0;    ///< number of the last new journal
  std::uint64_t awaited_ = 0;  ///< the last one that was ended from here
  std::uint64_t placed_ = 0;
  int lock_fd_ = -1;
  std::uint64_t dropped_ = 0;

  hal::Parking parking_;
  std::thread thread_;
};

}  // namespace g3d::net
