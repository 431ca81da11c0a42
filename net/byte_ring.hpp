// SPDX-License-Identifier: Apache-2.0
// Byte strings from one thread to another: a bounded lock-free queue between exactly two threads, one that pushes and
// one that pops. Strings have any length and lie one behind the other, so short ones cost no more than they are long.
// Memory is allocated in the constructor alone; neither side ever waits for the other.
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdint>
#include <cstring>

#include "hal/ring.hpp"
#include "mapper/files/bytes.hpp"

namespace g3d::net {

class ByteRing {
 public:
  /// Rounded up to a power of two, at least 64.
  explicit ByteRing(std::size_t capacity_bytes) : bytes_(std::bit_ceil(std::max<std::size_t>(capacity_bytes, 64))) {}
  ByteRing(const ByteRing&) = delete;
  ByteRing& operator=(const ByteRing&) = delete;

  /// Producer. False if there is no room; then nothing has changed.
  [[nodiscard]] bool try_push(mapper::ByteSpan string) {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);  // single writer: this thread
    const auto size = static_cast<std::uint32_t>(string.size());
    if (free_bytes() < sizeof size + string.size()) return false;
    write(tail, {reinterpret_cast<const std::uint8_t*>(&size), sizeof size});
    write(tail + sizeof size, string);
    tail_.store(tail + sizeof size + string.size(), std::memory_order_release);  // publishes the bytes
    return true;
  }
  /// Producer. What can be pushed, with four bytes around each string.
  [[nodiscard]] std::size_t free_bytes() const {
    // Acquire: the consumer's reads of what is free come before our next writes.
    return bytes_.size() -
           static_cast<std::size_t>(tail_.load(std::memory_order_relaxed) - head_.load(std::memory_order_acquire));
  }

  /// Consumer. False if empty. `string` takes the bytes; it allocates only if it has never been as long.
  [[nodiscard]] bool try_pop(mapper::Bytes& string) {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);  // single writer: this thread
    if (head == tail_.load(std::memory_order_acquire)) return false;
    std::uint32_t size = 0;
    read(head, {reinterpret_cast<std::uint8_t*>(&size), sizeof size});
    string.resize(size);
    read(head + sizeof size, string);
    head_.store(head + sizeof size + size, std::memory_order_release);
    return true;
  }
  /// Any thread; may be outdated on return.
  [[nodiscard]] bool empty() const {
    return head_.load(std::memory_order_acquire) == tail_.load(std::memory_order_acquire);
  }
  [[nodiscard]] std::size_t capacity_bytes() const { return bytes_.size(); }

 private:
  void write(std::uint64_t at, mapper::ByteSpan from) {
    if (from.empty()) return;
    const std::size_t place = static_cast<std::size_t>(at) & (bytes_.size() - 1);
    const std::size_t first = std::min(from.size(), bytes_.size() - place);
    std::memcpy(bytes_.data() + place, from.data(), first);
    if (first < from.size()) std::memcpy(bytes_.data(), from.data() + first, from.size() - first);
  }
  void read(std::uint64_t at, std::span<std::uint8_t> to) const {
    if (to.empty()) return;
    const std::size_t place = static_cast<std::size_t>(at) & (bytes_.size() - 1);
    const std::size_t first = std::min(to.size(), bytes_.size() - place);
    std::memcpy(to.data(), bytes_.data() + place, first);
    if (first < to.size()) std::memcpy(to.data() + first, bytes_.data(), to.size() - first);
  }

  mapper::Bytes bytes_;
  alignas(hal::kCacheLine_bytes) std::atomic<std::uint64_t> head_{0};
  alignas(hal::kCacheLine_bytes) std::atomic<std::uint64_t> tail_{0};
};

}  // namespace g3d::net
