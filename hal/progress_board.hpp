// SPDX-License-Identifier: Apache-2.0
// Who is still at work: every thread ticks an entry of its own, without a lock; somebody who feeds a watchdog asks for
// the first that is late. A thread that waits for the world outside (the next frame) rests: that may last.
//
//   thread:  for (;;) { entry->rest(); wait(); entry->tick(); work(); }
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hal/messages.hpp"
#include "hal/ring.hpp"

namespace g3d::hal {

class alignas(kCacheLine_bytes) ProgressEntry {
 public:
  /// The entry's own thread: it lives, and works from now on.
  void tick() { word_.store((word_.load(std::memory_order_relaxed) | kResting) + 1, std::memory_order_release); }
  /// The same thread: what it does now may take any time.
  void rest() { word_.store(word_.load(std::memory_order_relaxed) | kResting, std::memory_order_release); }

 private:
  friend class ProgressBoard;
  static constexpr std::uint64_t kResting = 1;
  std::atomic<std::uint64_t> word_{kResting};  ///< lowest bit: it rests; the others: ticks. Only its thread writes
};

class ProgressBoard {
 public:
  /// Before the threads begin. `limit_ns`: the longest between two ticks while it does not rest. The entry lives as
  /// long as the board, and rests until its first tick.
  [[nodiscard]] ProgressEntry& add(std::string name, TimeNs limit_ns);

  struct Late {
    const std::string* name = nullptr;  ///< nullptr: nobody
    TimeNs since_ns = 0;                ///< its last tick, as far as it was seen
  };
  /// One thread, a few times within the shortest limit. The one that is late for longest.
  [[nodiscard]] Late find_late(TimeNs now_ns);

 private:
  struct Watched {
    std::string name;
    TimeNs limit_ns = 0;
    std::unique_ptr<ProgressEntry> entry;
    std::uint64_t seen = ProgressEntry::kResting;
    TimeNs seen_ns = 0;
  };
  std::vector<Watched> watched_;
};

/// For a thread that may have no board.
inline void tick(ProgressEntry* entry) {
  if (entry != nullptr) entry->tick();
}
inline void rest(ProgressEntry* entry) {
  if (entry != nullptr) entry->rest();
}

}  // namespace g3d::hal
