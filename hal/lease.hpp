// SPDX-License-Identifier: Apache-2.0
// What two threads use in turn, and neither waits for: who finds it taken does something else and comes again.
#pragma once

#include <atomic>

namespace g3d::hal {

/// Whoever has taken it sees all that was done by who had it before. Any thread; nobody blocks.
class Lease {
 public:
  /// True: it is ours until give_back().
  [[nodiscard]] bool try_take() { return !is_taken_.exchange(true, std::memory_order_acquire); }
  void give_back() { is_taken_.store(false, std::memory_order_release); }

 private:
  std::atomic<bool> is_taken_{false};
};

}  // namespace g3d::hal
