// SPDX-License-Identifier: Apache-2.0
#include "net/layer_keeper.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>

#include "net/robot_identity.hpp"

namespace g3d::net {
namespace {

/// Of a record in the journal, besides its payload.
constexpr std::uint64_t kKeeperRecord_bytes = 20;
/// A journal is made anew when it is longer than this and twice what stands.
constexpr std::uint64_t kLeastJournal_bytes = 1 << 20;
/// Of a new journal at a time: a millisecond's work, and no more than a ring takes that nobody empties meanwhile.
constexpr std::size_t kKeeperStep_bytes = 128 * 1024;
std::size_t keeper_step_bytes(const JournalWriter& writer) {
  return std::min(kKeeperStep_bytes, writer.ring().capacity_bytes() / 8);
}

}  // namespace

LayerKeeper::LayerKeeper(const KeeperOptions& options, LayerStore& store)
    : options_(options),
      store_(store),
      writer_(options.folder + "/layers.journal", options.folder + "/identity", options.ring_bytes),
      claims_(store.most_layers(), false) {
  entry_.reserve(kMostEntry_bytes);
  payload_.reserve(kMostPayload_bytes);
}

hal::Result<std::unique_ptr<LayerKeeper>> LayerKeeper::open(const KeeperOptions& options, LayerStore& store) {
  if (std::find(options.dropped.begin(), options.dropped.end(), options.robot) != options.dropped.end()) {
    return hal::Error{hal::Reason::bad_usage,
                      fmt::format("robot {:016x}: its layers are dropped by the fleet's key; give it another id, and a "
                                  "folder of its own instead of {}",
                                  options.robot, options.folder)};
  }
  std::unique_ptr<LayerKeeper> keeper(new LayerKeeper(options, store));
  for (const RobotId robot : options.dropped) (void)store.refuse_robot(robot);
  std::error_code ignored;  // whoever writes there says what is wrong
  std::filesystem::create_directories(options.folder, ignored);
  if (!keeper->lock()) {
    return hal::Error{
        hal::Reason::no_permission,
        fmt::format("{}: another process keeps its layers here; each robot needs a folder of its own", options.folder)};
  }
  keeper->restore();
  keeper->take_identity();
  store.set_watch(keeper.get());
  if (options.has_thread) {
    LayerKeeper& of = *keeper;
    of.thread_ = std::thread([&of] {
      while (of.parking_.wait([&of] { return !of.writer_.ring().empty(); })) of.writer_.work();
    });
  }
  return keeper;
}

LayerKeeper::~LayerKeeper() {
  store_.set_watch(nullptr);
  parking_.stop();
  if (thread_.joinable()) thread_.join();
  if (lock_fd_ >= 0) ::close(lock_fd_);
}

bool LayerKeeper::lock() {
  // Two that write one layer would give the same versions.
  lock_fd_ = ::open(options_.folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  return lock_fd_ < 0 || ::flock(lock_fd_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

void LayerKeeper::restore() {
  auto restored = restore_layers(options_.folder + "/layers.journal", store_);
  if (restored) {
    restored_ = restored.value().counts;
    writer_.open(restored.value().good_bytes);
    // What is damaged, or has records that were not kept, is written anew.
    is_due_ = restored.value().is_damaged() || restored_.refused_records > 0;
  } else if (restored.error().reason == hal::Reason::not_found) {
    writer_.open(std::nullopt);
  } else {
    writer_.put_aside();
  }
}

void LayerKeeper::take_identity() {
  const std::string path = options_.folder + "/identity";
  const auto read = read_layer_identity(path);
  // A counter that is behind what is known of the layer is not the layer's.
  const auto fits = [&](const LayerIdentity& identity) {
    const LayerIndex layer = store_.find(identity.self);
    return identity.self.robot == options_.robot && (layer == kNoLayer || store_.highest(layer) <= identity.reserved);
  };
  if (read && fits(read.value()) && find_first_submap(read.value().self) < kMaxSubmaps) {
    identity_ = read.value();
    restored_upto_ = identity_.reserved;
    identity_.reserved += options_.reserve;
    if (identity_.reserved <= kMostVersion && write_layer_identity(path, identity_)) {
      first_reserved_ = identity_.reserved;
      is_named_ = true;
      if (const LayerIndex own = store_.find_or_add(identity_.self); own != kNoLayer) {
        // What it lacks is asked for from others as what lies between: see own_layer.hpp.
        store_.set_unclaimed(own, false);
      }
      return;
    }
  }
  // Nobody will go on with this layer unless the disk has taken its name; then it has taken the versions as well.
  do {
    identity_ = {{options_.robot, fresh_incarnation()}, options_.reserve};
  } while (store_.find(identity_.self) != kNoLayer);
  restored_upto_ = 0;
  first_submap_ = 0;
  first_reserved_ = identity_.reserved;
  is_named_ = write_layer_identity(path, identity_).ok();
}

std::uint32_t LayerKeeper::find_first_submap(const LayerId& self) {
  first_submap_ = 0;
  const LayerIndex own = store_.find(self);
  if (own == kNoLayer) return 0;
  store_.for_each(own, [&](const StoredRecord& record) {
    if (kind_of(record.key) == RecordKind::status) return;
    first_submap_ = std::max(first_submap_, submap_of_key(record.key) + 1);
  });
  return first_submap_;
}

std::optional<hal::Error> LayerKeeper::trouble() const {
  JournalTrouble trouble;
  if (writer_.trouble().read(trouble) == 0) return std::nullopt;
  return hal::Error{trouble.reason, trouble.text.data()};
}

KeeperCounts LayerKeeper::counts() const { return {writer_.counts(), dropped_, begun_}; }

Version LayerKeeper::version_limit() const { return std::max(first_reserved_, writer_.reserved()); }

// --- what changes

void LayerKeeper::push(JournalCommand command) {
  has_news_ = has_news_ || command == JournalCommand::change;
  if (writer_.push(command, entry_)) return;
  ++dropped_;
  new_has_lost_ = true;
  if (command == JournalCommand::change) has_lost_ = true;
}

void LayerKeeper::push_record(JournalCommand command, LayerIndex layer, const StoredRecord& record,
                              mapper::ByteSpan payload) {
  entry_.clear();
  add_layer_entry(entry_, store_.id(layer));
  add_record_entry(entry_, record, payload);
  push(command);
}

void LayerKeeper::push_claim(JournalCommand command, LayerIndex layer) {
  LayerPosition position{store_.id(layer), {}};
  for (const Lane lane : kAllLanes) position.had[static_cast<std::size_t>(lane)] = store_.had(layer, lane);
  entry_.clear();
  add_claim_entry(entry_, position, store_.is_unclaimed(layer));
  push(command);
}

void LayerKeeper::on_record(LayerIndex layer, const StoredRecord& record, mapper::ByteSpan payload) {
  if (payload.size() > kMostPayload_bytes) return;  // nobody sends such
  push_record(JournalCommand::change, layer, record, payload);
}

void LayerKeeper::push_claims() {
  // Behind a loss nothing is complete. Claims stay due.
  for (LayerIndex layer = 0; layer < store_.layer_count() && !has_lost_; ++layer) {
    if (!claims_[layer] || store_.is_refused(layer)) continue;
    push_claim(JournalCommand::change, layer);
    if (!has_lost_) claims_[layer] = false;
  }
}

void LayerKeeper::reserve(Version version, hal::TimeNs now_ns) {
  const bool is_asked = identity_.reserved > version_limit() || (!is_named_ && writer_.reserved() == 0);
  if (is_asked ? now_ns - reserved_ns_ < options_.again_ns : version + options_.reserve / 2 < version_limit()) return;
  if (!is_asked) identity_.reserved = std::min(kMostVersion, version + options_.reserve);
  reserved_ns_ = now_ns;
  entry_.assign(reinterpret_cast<const std::uint8_t*>(&identity_),
                reinterpret_cast<const std::uint8_t*>(&identity_) + sizeof identity_);
  (void)writer_.push(JournalCommand::reserve, entry_);
}

void LayerKeeper::wake() {
  if (options_.has_thread) {
    parking_.wake();
  } else {
    writer_.work();
  }
}

void LayerKeeper::on_time(Version version, hal::TimeNs now_ns) {
  if (writer_.placed_new() > placed_) {
    placed_ = writer_.placed_new();
    has_lost_ = new_has_lost_;
  }
  if (walk_) {
    add_to_journal();
  } else if (journal_is_due(now_ns)) {
    begin_journal(now_ns);
  }
  const bool is_filling = writer_.ring().free_bytes() < writer_.ring().capacity_bytes() / 2;
  if (now_ns - flushed_ns_ < options_.flush_ns && !is_filling) return;
  flushed_ns_ = now_ns;
  push_claims();
  reserve(version, now_ns);
  if (has_news_ && now_ns - synced_ns_ >= options_.sync_ns) {
    entry_.clear();
    if (writer_.push(JournalCommand::sync, entry_)) has_news_ = false;
    synced_ns_ = now_ns;
  }
  if (!writer_.ring().empty()) wake();
}

void LayerKeeper::close(Version version) {
  push_claims();
  entry_.clear();
  (void)writer_.push(JournalCommand::sync, entry_);
  identity_.reserved = std::max(version, restored_upto_);
  entry_.assign(reinterpret_cast<const std::uint8_t*>(&identity_),
                reinterpret_cast<const std::uint8_t*>(&identity_) + sizeof identity_);
  (void)writer_.push(JournalCommand::reserve, entry_);
  store_.set_watch(nullptr);
  wake();
  parking_.stop();
  if (thread_.joinable()) thread_.join();
}

// --- a new journal

bool LayerKeeper::journal_is_due(hal::TimeNs now_ns) const {
  if (awaited_ > writer_.ended_new() || (begun_ > 0 && now_ns - begun_ns_ < options_.again_ns)) return false;
  const std::uint64_t standing_bytes =
      store_.payload_bytes() + std::uint64_t{store_.record_count()} * kKeeperRecord_bytes;
  return has_lost_ || is_due_ || writer_.needs_new() ||
         writer_.journal_bytes() > kLeastJournal_bytes + 2 * standing_bytes;
}

void LayerKeeper::begin_journal(hal::TimeNs now_ns) {
  const std::uint64_t number = begun_ + 1;
  entry_.assign(reinterpret_cast<const std::uint8_t*>(&number),
                reinterpret_cast<const std::uint8_t*>(&number) + sizeof number);
  if (!writer_.push(JournalCommand::new_begin, entry_)) return;
  begun_ = number;
  begun_ns_ = now_ns;
  new_has_lost_ = false;
  is_due_ = false;
  walk_ = Walk{};
}

bool LayerKeeper::add_records(LayerIndex layer) {
  for (std::size_t bytes = 0; walk_->lane < kLanes;) {
    const auto record = store_.first_after(layer, static_cast<Lane>(walk_->lane), walk_->version);
    if (!record) {
      ++walk_->lane;
      walk_->version = 0;
      continue;
    }
    walk_->version = record->version;
    payload_.resize(record->bytes);
    store_.read(*record, payload_);
    push_record(JournalCommand::new_entry, layer, *record, payload_);
    bytes += entry_.size();
    if (bytes >= keeper_step_bytes(writer_) || new_has_lost_) return false;
  }
  return true;
}

void LayerKeeper::add_to_journal() {
  if (writer_.ended_new() >= begun_) return walk_.reset();  // the disk refuses it
  // Half of the ring is left for what changes meanwhile.
  if (!writer_.has_room_for(writer_.ring().capacity_bytes() / 2 + 2 * keeper_step_bytes(writer_))) return;
  while (walk_->layer < store_.layer_count() && !new_has_lost_) {
    if (!store_.is_refused(walk_->layer)) {
      if (!add_records(walk_->layer)) break;
      push_claim(JournalCommand::new_entry, walk_->layer);
    }
    *walk_ = {walk_->layer + 1, 0, 0};
  }
  if (!new_has_lost_ && walk_->layer < store_.layer_count()) return;
  walk_.reset();
  // One from which something is missing is not put in the other's place.
  entry_.clear();
  if (!new_has_lost_ && writer_.push(JournalCommand::new_end, entry_)) {
    awaited_ = begun_;
  } else {
    is_due_ = true;
  }
}

}  // namespace g3d::net
