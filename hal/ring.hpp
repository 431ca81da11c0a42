// SPDX-License-Identifier: Apache-2.0
// Bounded lock-free queue between exactly two threads, one that pushes and one that pops. Memory is allocated in the
// constructor alone. Neither side ever waits for the other; how to wait for a ring is in parking.hpp.
//
//        head_ (oldest)           tail_ (next free)
//          v                        v
//   | . |  a  |  b  |  c  |  d  |  .  |  .  |        indices only grow; slot = index & mask
//
// When full, try_push refuses the newest value, and push_overwrite_oldest takes out the oldest. The latter makes the
// producer a second taker of `head_`, so both take by compare-and-swap, and values lie in the slots as words that are
// themselves atomic: the consumer may be reading the very slot that is being given up. It then reads a mixture, but
// its compare-and-swap fails and the mixture is thrown away.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <type_traits>

namespace g3d::hal {

/// Two x86 lines, as neighbours are fetched in pairs; one or more on every ARM core.
inline constexpr std::size_t kCacheLine_bytes = 128;

template <typename T>
class Ring {
  static_assert(std::is_trivially_copyable_v<T>, "values cross the ring as plain words");

 public:
  /// `capacity` values fit, at least 1.
  explicit Ring(std::size_t capacity)
      : capacity_(std::max<std::size_t>(capacity, 1)),
        mask_(std::bit_ceil(capacity_) - 1),
        words_(std::make_unique<Word[]>((mask_ + 1) * kWords)) {}
  Ring(const Ring&) = delete;
  Ring& operator=(const Ring&) = delete;

  /// Producer. False if full: the value stays with the caller.
  [[nodiscard]] bool try_push(const T& value) {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);  // single writer: this thread
    if (tail - cached_head_ >= capacity_) {
      cached_head_ = head_.load(std::memory_order_acquire);  // the consumer has read the slots below
      if (tail - cached_head_ >= capacity_) return false;
    }
    publish(tail, value);
    return true;
  }

  /// Producer. Always takes `value`; when full, the oldest value is taken out, counted in dropped() and returned, so
  /// that the caller can give back what it refers to.
  std::optional<T> push_overwrite_oldest(const T& value) {
    if (try_push(value)) return std::nullopt;
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);  // single writer: this thread
    std::uint64_t head = tail - capacity_;
    std::optional<T> oldest = read_slot(head);
    // Acquire in both outcomes: before the slot is reused, the consumer's reads of it must be over.
    if (head_.compare_exchange_strong(head, head + 1, std::memory_order_acq_rel, std::memory_order_acquire)) {
      dropped_.store(dropped_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);  // single writer
      ++head;
    } else {
      oldest.reset();  // the consumer took it in this moment: there is room now
    }
    cached_head_ = head;
    publish(tail, value);
    return oldest;
  }

  /// Consumer. False if empty; then `value` is unspecified.
  [[nodiscard]] bool try_pop(T& value) {
    std::uint64_t head = head_.load(std::memory_order_acquire);  // the producer may have moved it, after its tail
    for (;;) {
      if (head >= cached_tail_) {
        cached_tail_ = tail_.load(std::memory_order_acquire);  // makes the words below it visible
        if (head >= cached_tail_) return false;
      }
      value = read_slot(head);
      // Release: our reads of the slot come before the producer's next writes into it.
      if (head_.compare_exchange_strong(head, head + 1, std::memory_order_acq_rel, std::memory_order_acquire)) {
        return true;
      }
    }
  }

  /// Any thread; a snapshot that may be outdated on return.
  [[nodiscard]] std::size_t size() const {
    const std::uint64_t head = head_.load(std::memory_order_acquire);
    const std::uint64_t tail = tail_.load(std::memory_order_acquire);  // later than head, so never below it
    return static_cast<std::size_t>(std::min<std::uint64_t>(tail - head, capacity_));
  }
  [[nodiscard]] bool empty() const { return size() == 0; }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }
  /// Any thread. How many values push_overwrite_oldest took out; a refused try_push loses nothing and is not counted.
  [[nodiscard]] std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

 private:
  using Word = std::atomic<std::uint64_t>;
  static constexpr std::size_t kWords = (sizeof(T) + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t);

  Word* slot(std::uint64_t index) const { return &words_[(index & mask_) * kWords]; }

  void publish(std::uint64_t tail, const T& value) {
    std::array<std::uint64_t, kWords> words{};
    std::memcpy(words.data(), &value, sizeof(T));
    Word* const to = slot(tail);
    for (std::size_t i = 0; i < kWords; ++i) to[i].store(words[i], std::memory_order_relaxed);
    tail_.store(tail + 1, std::memory_order_release);  // publishes the words
  }

  T read_slot(std::uint64_t index) const {
    std::array<std::uint64_t, kWords> words;
    const Word* const from = slot(index);
    for (std::size_t i = 0; i < kWords; ++i) words[i] = from[i].load(std::memory_order_relaxed);
    std::array<std::byte, sizeof(T)> bytes;
    std::memcpy(bytes.data(), words.data(), sizeof(T));
    return std::bit_cast<T>(bytes);
  }

  const std::size_t capacity_;
  const std::size_t mask_;
  const std::unique_ptr<Word[]> words_;

  // Taken by both sides, nearly always by the consumer.
  alignas(kCacheLine_bytes) std::atomic<std::uint64_t> head_{0};
  // The consumer's own; a cached index spares a read of the other thread's line.
  alignas(kCacheLine_bytes) std::uint64_t cached_tail_ = 0;
  // Written by the producer alone.
  alignas(kCacheLine_bytes) std::atomic<std::uint64_t> tail_{0};
  // The producer's own, and its counter.
  alignas(kCacheLine_bytes) std::uint64_t cached_head_ = 0;
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace g3d::hal
