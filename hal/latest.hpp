// SPDX-License-Identifier: Apache-2.0
// One value of which only the newest matters (a pose, a twist), from one writer to any number of readers. The writer
// never waits; a reader gets a whole value and its generation, even while the writer is stopped in the middle of the
// next one, because that one goes to another slot.
//
// Why it is right without fences: words are stored with release after `started_`, and loaded with acquire before it is
// checked. Who has read even one word of generation g also sees started_ >= g, and rejects what it read of an older
// one.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "hal/ring.hpp"

namespace g3d::hal {

template <typename T>
class Latest {
  static_assert(std::is_trivially_copyable_v<T>, "values cross as plain words");

 public:
  Latest() = default;
  Latest(const Latest&) = delete;
  Latest& operator=(const Latest&) = delete;

  /// The one writer's thread.
  void write(const T& value) {
    const std::uint64_t generation = published_.load(std::memory_order_relaxed) + 1;  // single writer: this thread
    std::array<std::uint64_t, kWords> words{};
    std::memcpy(words.data(), &value, sizeof(T));
    started_.store(generation, std::memory_order_relaxed);  // ordered before the words by their release
    Slot& slot = slots_[generation % kSlots];
    for (std::size_t i = 0; i < kWords; ++i) slot[i].store(words[i], std::memory_order_release);
    published_.store(generation, std::memory_order_release);
  }

  /// Any thread. Returns the value's generation: 1 for the first written, 0 (and `value` untouched) before that.
  /// Repeats only if the writer wrote kSlots - 1 values meanwhile.
  [[nodiscard]] std::uint64_t read(T& value) const {
    for (;;) {
      const std::uint64_t generation = published_.load(std::memory_order_acquire);
      if (generation == 0) return 0;
      std::array<std::uint64_t, kWords> words;
      const Slot& slot = slots_[generation % kSlots];
      for (std::size_t i = 0; i < kWords; ++i) words[i] = slot[i].load(std::memory_order_acquire);
      // Relaxed is enough: the acquires above keep it behind them.
      if (started_.load(std::memory_order_relaxed) >= generation + kSlots) continue;
      std::array<std::byte, sizeof(T)> bytes;
      std::memcpy(bytes.data(), words.data(), sizeof(T));
      value = std::bit_cast<T>(bytes);
      return generation;
    }
  }

  /// Any thread. True and a new `value` only if there is one newer than `seen`, which it then moves on.
  [[nodiscard]] bool read_newer(std::uint64_t& seen, T& value) const {
    if (generation() <= seen) return false;
    seen = read(value);
    return true;
  }

  /// Any thread. How often a value has been written.
  [[nodiscard]] std::uint64_t generation() const { return published_.load(std::memory_order_acquire); }

 private:
  static constexpr std::size_t kSlots = 4;
  static constexpr std::size_t kWords = (sizeof(T) + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t);
  using Slot = std::array<std::atomic<std::uint64_t>, kWords>;

  alignas(kCacheLine_bytes) std::atomic<std::uint64_t> published_{0};
  std::atomic<std::uint64_t> started_{0};
  alignas(kCacheLine_bytes) std::array<Slot, kSlots> slots_{};
};

}  // namespace g3d::hal
