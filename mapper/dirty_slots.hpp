// SPDX-License-Identifier: Apache-2.0
// Which blocks of a map have changed since somebody looked last: state, not messages, so a slow reader is late, never
// wrong. One bit per slot. Threads: one notes, another takes; neither waits for the other.
#pragma once

#include <atomic>
#include <bit>
#include <cstdint>
#include <memory>
#include <span>

namespace g3d::mapper {

class DirtySlots {
 public:
  explicit DirtySlots(std::uint32_t slots)
      : words_((slots + 63) / 64), bits_(std::make_unique<std::atomic<std::uint64_t>[]>(words_)) {}

  /// After the block was written: what the other thread then reads is at least that new.
  void note(std::uint32_t slot) {
    bits_[slot / 64].fetch_or(std::uint64_t{1} << (slot % 64), std::memory_order_release);
  }
  void note(std::span<const std::uint32_t> slots) {
    for (const std::uint32_t slot : slots) note(slot);
  }
  /// visit(slot) for each that was noted, in ascending order; from then on they are not noted any more.
  template <typename Visit>
  void take_each(Visit&& visit) {
    for (std::uint32_t word = 0; word < words_; ++word) {
      if (bits_[word].load(std::memory_order_relaxed) == 0) continue;
      std::uint64_t left = bits_[word].exchange(0, std::memory_order_acquire);
      for (; left != 0; left &= left - 1) visit(word * 64 + static_cast<std::uint32_t>(std::countr_zero(left)));
    }
  }

 private:
  std::uint32_t words_;
  std::unique_ptr<std::atomic<std::uint64_t>[]> bits_;
};

}  // namespace g3d::mapper
