// SPDX-License-Identifier: Apache-2.0
// Dial's priority queue for integer keys that never fall behind the last one taken: a ring of stacks, one per key, and
// a bit per stack to skip empty ones. Push and pop cost a few nanoseconds whatever it holds; last in, first out among
// equal keys. Entries come from a pool that is sized at construction.
#pragma once

#include <array>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>

#include "mapper/pool.hpp"

namespace g3d::nav {

class BucketQueue {
 public:
  static constexpr std::uint32_t kBuckets = 2048;  ///< keys may lead the last one taken by less than this

  explicit BucketQueue(std::size_t max_entries) : entries_(max_entries + 1) {}

  void clear(std::uint32_t first_key) {
    heads_.fill(0);
    words_.fill(0);
    free_ = 0;
    used_ = 0;
    size_ = 0;
    key_ = first_key;
  }
  [[nodiscard]] bool empty() const { return size_ == 0; }

  void push(std::uint32_t key, std::uint32_t value) {
    assert(key >= key_ && key - key_ < kBuckets);
    std::uint32_t place = free_;
    if (place != 0) {
      free_ = entries_[place].next;
    } else {
      place = ++used_;
      assert(place < entries_.size());
    }
    const std::uint32_t bucket = key % kBuckets;
    entries_[place] = {value, heads_[bucket]};
    heads_[bucket] = place;
    words_[bucket / 64] |= std::uint64_t{1} << (bucket % 64);
    ++size_;
  }

  /// The value with the smallest key. Not when empty.
  std::uint32_t pop() {
    assert(size_ > 0);
    std::uint32_t bucket = key_ % kBuckets;
    if (heads_[bucket] == 0) {
      const std::uint32_t next = next_filled(bucket);
      key_ += (next - bucket) % kBuckets;
      bucket = next;
    }
    const std::uint32_t place = heads_[bucket];
    const Entry entry = entries_[place];
    heads_[bucket] = entry.next;
    if (entry.next == 0) words_[bucket / 64] &= ~(std::uint64_t{1} << (bucket % 64));
    entries_[place].next = free_;
    free_ = place;
    --size_;
    return entry.value;
  }
  /// Of the last pop().
  [[nodiscard]] std::uint32_t key() const { return key_; }

 private:
  struct Entry {
    std::uint32_t value;
    std::uint32_t next;  ///< 0: last
  };

  [[nodiscard]] std::uint32_t next_filled(std::uint32_t bucket) const {
    std::uint32_t word = bucket / 64;
    std::uint64_t bits = words_[word] & (~std::uint64_t{0} << (bucket % 64));
    while (bits == 0) {
      word = (word + 1) % kWords;
      bits = words_[word];
    }
    return word * 64 + static_cast<std::uint32_t>(std::countr_zero(bits));
  }

  static constexpr std::uint32_t kWords = kBuckets / 64;
  mapper::ReservedArray<Entry> entries_;  ///< place 0 is nobody's
  std::array<std::uint32_t, kBuckets> heads_{};
  std::array<std::uint64_t, kWords> words_{};
  std::uint32_t free_ = 0;
  std::uint32_t used_ = 0;
  std::uint32_t key_ = 0;
  std::size_t size_ = 0;
};

}  // namespace g3d::nav
