// SPDX-License-Identifier: Apache-2.0
#include "hal/progress_board.hpp"

#include <utility>

namespace g3d::hal {

ProgressEntry& ProgressBoard::add(std::string name, TimeNs limit_ns) {
  watched_.push_back({std::move(name), limit_ns, std::make_unique<ProgressEntry>(), ProgressEntry::kResting, 0});
  return *watched_.back().entry;
}

ProgressBoard::Late ProgressBoard::find_late(TimeNs now_ns) {
  Late latest;
  TimeNs most_over_ns = 0;
  for (Watched& watched : watched_) {
    const std::uint64_t word = watched.entry->word_.load(std::memory_order_acquire);
    if (word != watched.seen || (word & ProgressEntry::kResting) != 0) {
      watched.seen = word;
      watched.seen_ns = now_ns;
      continue;
    }
    const TimeNs over_ns = now_ns - watched.seen_ns - watched.limit_ns;
    if (over_ns <= most_over_ns) continue;
    most_over_ns = over_ns;
    latest = {&watched.name, watched.seen_ns};
  }
  return latest;
}

}  // namespace g3d::hal
