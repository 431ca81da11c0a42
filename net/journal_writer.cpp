// SPDX-License-Identifier: Apache-2.0
#include "net/journal_writer.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "hal/disk.hpp"
#include "net/journal_entry.hpp"

namespace g3d::net {

JournalWriter::JournalWriter(std::string journal_path, std::string identity_path, std::size_t ring_bytes)
    : journal_path_(std::move(journal_path)), identity_path_(std::move(identity_path)), ring_(ring_bytes) {
  pushed_.reserve(kMostEntry_bytes);
  popped_.reserve(kMostEntry_bytes);
  for (Target& target : journals_) {
    target.entries.reserve(kFrame_bytes + kMostEntry_bytes);
    target.layer.reserve(kLayerEntry_bytes);
  }
}

void JournalWriter::open(std::optional<std::uint64_t> good_bytes) {
  const hal::Result<void> opened =
      good_bytes ? current_->file.open(journal_path_, *good_bytes) : current_->file.create(journal_path_);
  if (!opened) return note(opened.error());
  journal_bytes_.store(current_->file.bytes(), std::memory_order_relaxed);
  needs_new_.store(false, std::memory_order_release);
}

bool JournalWriter::push(JournalCommand command, mapper::ByteSpan bytes) {
  pushed_.clear();
  pushed_.push_back(static_cast<std::uint8_t>(command));
  mapper::put_bytes(pushed_, bytes);
  return ring_.try_push(pushed_);
}

JournalCounts JournalWriter::counts() const {
  const auto of = [](const std::atomic<std::uint64_t>& counter) { return counter.load(std::memory_order_relaxed); };
  return {of(frames_), of(written_bytes_), of(syncs_), of(failures_), of(discarded_), of(new_journals_)};
}

// --- what waits for the disk

void JournalWriter::Target::add(mapper::ByteSpan more) {
  // Neighbours are mostly of one layer: it is named once.
  if (more.size() > kLayerEntry_bytes && !layer.empty() &&
      std::equal(layer.begin(), layer.end(), more.begin(), more.begin() + kLayerEntry_bytes)) {
    more = more.subspan(kLayerEntry_bytes);
  } else if (more.size() > kLayerEntry_bytes && more[0] == 1) {
    layer.assign(more.begin(), more.begin() + kLayerEntry_bytes);
  }
  mapper::put_bytes(entries, more);
}

void JournalWriter::Target::clear() {
  entries.clear();
  layer.clear();
}

void JournalWriter::note(const hal::Error& error) {
  count(failures_);
  JournalTrouble trouble;
  trouble.reason = error.reason;
  std::memcpy(trouble.text.data(), error.text.data(), std::min(error.text.size(), trouble.text.size() - 1));
  trouble_.write(trouble);
}

void JournalWriter::fail(Target& target, const hal::Error& error) {
  note(error);
  target.file.close();
  target.clear();
  if (&target == current_) {
    needs_new_.store(true, std::memory_order_release);
  } else {
    ended_new_.store(new_number_, std::memory_order_release);
  }
}

void JournalWriter::add(Target& target, mapper::ByteSpan entries) {
  if (!target.file.is_open()) return;
  target.add(entries);
  if (target.entries.size() >= kFrame_bytes) flush(target);
}

void JournalWriter::flush(Target& target) {
  if (target.entries.empty() || !target.file.is_open()) return;
  if (const auto written = target.file.append(target.entries); !written) return fail(target, written.error());
  count(frames_);
  count(written_bytes_, target.entries.size());
  target.clear();
  if (&target == current_) journal_bytes_.store(target.file.bytes(), std::memory_order_relaxed);
}

void JournalWriter::flush() {
  flush(*current_);
  flush(*next_);
}

void JournalWriter::end_new() {
  flush(*next_);
  if (!next_->file.is_open()) return;
  if (std::exchange(keeps_old_, false)) {
    (void)hal::disk().rename(journal_path_.c_str(), (journal_path_ + ".unread").c_str());
  }
  const auto replaced = next_->file.replace(journal_path_);
  if (!replaced && !next_->file.is_at(journal_path_)) return fail(*next_, replaced.error());
  current_->file.close();
  current_->clear();
  std::swap(current_, next_);
  count(new_journals_);
  journal_bytes_.store(current_->file.bytes(), std::memory_order_relaxed);
  synced_bytes_.store(current_->file.bytes(), std::memory_order_relaxed);
  if (!replaced) note(replaced.error());
  placed_new_.store(new_number_, std::memory_order_release);
  needs_new_.store(!replaced, std::memory_order_release);
  ended_new_.store(new_number_, std::memory_order_release);
}

void JournalWriter::take(JournalCommand command, mapper::ByteSpan bytes) {
  switch (command) {
    case JournalCommand::change:
      if (!current_->file.is_open()) count(discarded_);
      add(*current_, bytes);
      add(*next_, bytes);
      return;
    case JournalCommand::new_begin:
      std::memcpy(&new_number_, bytes.data(), sizeof new_number_);
      next_->clear();
      if (const auto made = next_->file.create(journal_path_ + ".new"); !made) fail(*next_, made.error());
      return;
    case JournalCommand::new_entry:
      return add(*next_, bytes);
    case JournalCommand::new_end:
      return end_new();
    case JournalCommand::sync:
      flush();
      if (!current_->file.is_open()) return;
      if (const auto synced = current_->file.sync(); !synced) return fail(*current_, synced.error());
      count(syncs_);
      synced_bytes_.store(current_->file.bytes(), std::memory_order_relaxed);
      return;
    case JournalCommand::reserve: {
      LayerIdentity identity;
      std::memcpy(&identity, bytes.data(), sizeof identity);
      if (const auto written = write_layer_identity(identity_path_, identity); !written) return note(written.error());
      reserved_.store(identity.reserved, std::memory_order_release);
      return;
    }
  }
}

void JournalWriter::work() {
  while (ring_.try_pop(popped_)) take(static_cast<JournalCommand>(popped_[0]), mapper::ByteSpan(popped_).subspan(1));
  flush();
}

}  // namespace g3d::net
