// SPDX-License-Identifier: Apache-2.0
// How a thread waits for a ring without a lock and without burning a core. One Parking belongs to one thread that
// waits; everyone who changes something it may wait for (pushed, popped, released) calls wake() afterwards.
//
//   waiting thread:  while (parking.wait([&] { return ring.try_pop(message); })) handle(message);
//   other thread:    if (ring.try_push(message)) parking.wake();
//   to end it:       parking.stop();
#pragma once

#include <atomic>
#include <cstdint>

namespace g3d::hal {

class Parking {
 public:
  /// The waiting thread. Returns true as soon as `ready()` does, false once stopped. What is ready is still taken after
  /// a stop, so a consumer drains its ring before it ends.
  template <typename Ready>
  [[nodiscard]] bool wait(Ready&& ready) {
    for (;;) {
      // Read before the question: a wake() after the answer changes it, and then the sleep below does not begin.
      const std::uint32_t wakes = wakes_.load(std::memory_order_seq_cst);
      if (ready()) return true;
      if (stopped()) return false;
      wakes_.wait(wakes, std::memory_order_seq_cst);  // spins a little, then sleeps in the kernel
    }
  }

  /// Any thread. Costs a read-modify-write, and a system call only if the thread sleeps.
  void wake() {
    wakes_.fetch_add(1, std::memory_order_seq_cst);
    wakes_.notify_all();
  }

  /// Any thread, for good.
  void stop() {
    stopped_.store(true, std::memory_order_release);
    wake();
  }
  [[nodiscard]] bool stopped() const { return stopped_.load(std::memory_order_acquire); }

 private:
  std::atomic<std::uint32_t> wakes_{0};  // 32 bits: what the kernel can sleep on directly
  std::atomic<bool> stopped_{false};
};

}  // namespace g3d::hal
