// SPDX-License-Identifier: Apache-2.0
#include "net/replay_window.hpp"

namespace g3d::net {

void ReplayWindow::begin_at(std::uint64_t counter) {
  highest_ = counter;
  seen_.fill(~std::uint64_t{0});
}

Freshness ReplayWindow::take(std::uint64_t counter) {
  if (counter > highest_) {
    if (counter - highest_ >= kWidth) {
      seen_.fill(0);
    } else {
      for (std::uint64_t skipped = highest_ + 1; skipped < counter; ++skipped) word_of(skipped) &= ~bit_of(skipped);
    }
    highest_ = counter;
    word_of(counter) |= bit_of(counter);
    return Freshness::fresh;
  }
  if (highest_ - counter >= kWidth) return Freshness::too_old;
  if ((word_of(counter) & bit_of(counter)) != 0) return Freshness::replayed;
  word_of(counter) |= bit_of(counter);
  return Freshness::fresh;
}

}  // namespace g3d::net
