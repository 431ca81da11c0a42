// SPDX-License-Identifier: Apache-2.0
// A hash table from 64-bit keys to small plain values whose memory is reserved once: it never grows, allocates or moves
// to another place. Untouched pages cost nothing. One thread.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "mapper/pool.hpp"

namespace g3d::mapper {

template <typename Value>
class FixedTable {
  static_assert(std::is_trivially_copyable_v<Value>);

 public:
  /// Holds up to `capacity` keys, at least 1.
  explicit FixedTable(std::uint32_t capacity)
      : capacity_(capacity == 0 ? 1 : capacity),
        mask_(std::bit_ceil(std::size_t{capacity_} * 2) - 1),
        entries_(mask_ + 1) {}

  /// nullptr if absent. Pointers are valid until the next insert or erase.
  [[nodiscard]] Value* find(std::uint64_t key) {
    Entry& entry = entries_[place_of(key)];
    return entry.tag != 0 ? &entry.value : nullptr;
  }
  [[nodiscard]] const Value* find(std::uint64_t key) const {
    const Entry& entry = entries_[place_of(key)];
    return entry.tag != 0 ? &entry.value : nullptr;
  }
  /// The value of a key, made if absent; nullptr if it is absent and the table is full.
  [[nodiscard]] Value* find_or_insert(std::uint64_t key) {
    Entry& entry = entries_[place_of(key)];
    if (entry.tag != 0) return &entry.value;
    if (size_ == capacity_) return nullptr;
    ++size_;
    entry.tag = key + 1;
    entry.value = Value{};
    return &entry.value;
  }
  bool erase(std::uint64_t key) {
    std::size_t hole = place_of(key);
    if (entries_[hole].tag == 0) return false;
    // Linear probing without tombstones: move up every later entry that may not stand behind the hole.
    for (std::size_t next = (hole + 1) & mask_; entries_[next].tag != 0; next = (next + 1) & mask_) {
      const std::size_t home = home_of(entries_[next].tag - 1);
      if (((next - home) & mask_) < ((next - hole) & mask_)) continue;
      entries_[hole] = entries_[next];
      hole = next;
    }
    entries_[hole].tag = 0;
    --size_;
    return true;
  }
  /// visit(key, value) for all, in no particular order.
  template <typename Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t i = 0, left = size_; left > 0; ++i) {
      if (entries_[i].tag == 0) continue;
      visit(entries_[i].tag - 1, entries_[i].value);
      --left;
    }
  }
  [[nodiscard]] std::uint32_t size() const { return size_; }
  [[nodiscard]] std::uint32_t capacity() const { return capacity_; }

 private:
  struct Entry {
    std::uint64_t tag;  ///< key + 1; 0 = empty
    Value value;
  };
  [[nodiscard]] std::size_t home_of(std::uint64_t key) const {
    key *= 0x9E3779B97F4A7C15ULL;
    return static_cast<std::size_t>(key ^ (key >> 32)) & mask_;
  }
  [[nodiscard]] std::size_t place_of(std::uint64_t key) const {
    std::size_t place = home_of(key);
    while (entries_[place].tag != 0 && entries_[place].tag != key + 1) place = (place + 1) & mask_;
    return place;
  }

  std::uint32_t capacity_;
  std::size_t mask_;
  ReservedArray<Entry> entries_;
  std::uint32_t size_ = 0;
};

}  // namespace g3d::mapper
