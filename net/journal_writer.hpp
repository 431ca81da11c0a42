// SPDX-License-Identifier: Apache-2.0
// The side of a journal that waits for the disk: takes entries from a ring, writes what has gathered as one frame,
// syncs when it is told, and puts a new journal in the old one's place. While a new one is written beside, what changes
// goes to both, so that the old one is good until the new one is.
//
// A journal that the disk refuses is left as it is, good to its last whole frame, and nothing is added to it any more:
// what comes later may stand on what is missing. It takes a new one to go on (needs_new()).
//
// Threads: push() and what it says of itself belong to the thread that owns the store; work() to one other, or the
// same.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "hal/latest.hpp"
#include "hal/result.hpp"
#include "net/byte_ring.hpp"
#include "net/journal_file.hpp"
#include "net/layer_identity.hpp"

namespace g3d::net {

enum class JournalCommand : std::uint8_t {
  change,     ///< entries for the journal, and for the new one while there is one
  new_begin,  ///< number of the new journal (u64)
  new_entry,  ///< entries for the new one alone
  new_end,    ///< it is complete and takes the other's place
  sync,
  reserve,  ///< a LayerIdentity, to be written
};

/// Why the disk refused something. Text ends with zero.
struct JournalTrouble {
  hal::Reason reason = hal::Reason::io_error;
  std::array<char, 240> text{};
};

struct JournalCounts {
  std::uint64_t frames = 0;
  std::uint64_t written_bytes = 0;
  std::uint64_t syncs = 0;
  std::uint64_t failures = 0;
  std::uint64_t discarded_entries = 0;  ///< while there was no journal to take them
  std::uint64_t new_journals = 0;
};

class JournalWriter {
 public:
  /// Entries are gathered up to so much.
  static constexpr std::size_t kFrame_bytes = 64 * 1024;

  JournalWriter(std::string journal_path, std::string identity_path, std::size_t ring_bytes);

  /// Before anything is pushed: goes on behind so many bytes of the journal that is there; none: there is none. Whether
  /// that went well, needs_new() says.
  void open(std::optional<std::uint64_t> good_bytes);
  /// Instead: there is a file that could not be read. It is put aside when a new journal takes its place.
  void put_aside() { keeps_old_ = true; }

  // --- the store's thread

  /// False if there is no room.
  [[nodiscard]] bool push(JournalCommand command, mapper::ByteSpan bytes);
  [[nodiscard]] bool has_room_for(std::size_t bytes) const { return ring_.free_bytes() > bytes; }
  [[nodiscard]] const ByteRing& ring() const { return ring_; }
  [[nodiscard]] bool needs_new() const { return needs_new_.load(std::memory_order_acquire); }
  /// Of the last new journal that ended, well or not, and of the last that took the other's place.
  [[nodiscard]] std::uint64_t ended_new() const { return ended_new_.load(std::memory_order_acquire); }
  [[nodiscard]] std::uint64_t placed_new() const { return placed_new_.load(std::memory_order_acquire); }
  [[nodiscard]] std::uint64_t journal_bytes() const { return journal_bytes_.load(std::memory_order_relaxed); }
  /// Of the journal: survives a power cut.
  [[nodiscard]] std::uint64_t synced_bytes() const { return synced_bytes_.load(std::memory_order_relaxed); }
  /// Up to which version of our own layer the disk has reserved. 0: it has not, since this began.
  [[nodiscard]] Version reserved() const { return reserved_.load(std::memory_order_acquire); }
  [[nodiscard]] JournalCounts counts() const;
  /// The last one; generation 0 if there was none.
  [[nodiscard]] const hal::Latest<JournalTrouble>& trouble() const { return trouble_; }

  // --- the other one

  /// Until the ring is empty. Waits for the disk.
  void work();

 private:
  struct Target {
    JournalFile file;
    mapper::Bytes entries;  ///< of the frame that gathers
    mapper::Bytes layer;    ///< the layer entry that stands last in it
    void add(mapper::ByteSpan more);
    void clear();
  };
  void take(JournalCommand command, mapper::ByteSpan bytes);
  void add(Target& target, mapper::ByteSpan entries);
  void flush();
  void flush(Target& target);
  void end_new();
  void note(const hal::Error& error);
  void fail(Target& target, const hal::Error& error);
  static void count(std::atomic<std::uint64_t>& counter, std::uint64_t more = 1) {
    counter.store(counter.load(std::memory_order_relaxed) + more, std::memory_order_relaxed);  // single writer
  }

  const std::string journal_path_;
  const std::string identity_path_;
  ByteRing ring_;
  mapper::Bytes pushed_;  ///< the store's thread
  mapper::Bytes popped_;
  Target journals_[2];
  Target* current_ = &journals_[0];
  Target* next_ = &journals_[1];
  std::uint64_t new_number_ = 0;
  std::atomic<bool> needs_new_{true};
  std::atomic<std::uint64_t> ended_new_{0};
  std::atomic<std::uint64_t> placed_new_{0};
  bool keeps_old_ = false;
  std::atomic<std::uint64_t> journal_bytes_{0};
  std::atomic<std::uint64_t> synced_bytes_{0};
  std::atomic<Version> reserved_{0};
  std::atomic<std::uint64_t> frames_{0}, written_bytes_{0}, syncs_{0}, failures_{0}, discarded_{0}, new_journals_{0};
  hal::Latest<JournalTrouble> trouble_;
};

}  // namespace g3d::net
