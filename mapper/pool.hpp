// SPDX-License-Identifier: Apache-2.0
// Memory sized at start: address space is reserved once, pages come to life when first touched, nothing ever moves.
#pragma once

#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <new>
#include <type_traits>

namespace g3d::mapper {

/// A fixed array of zero bytes in its own mapping. Untouched pages cost nothing.
template <typename T>
class ReservedArray {
  static_assert(std::is_trivially_destructible_v<T>);

 public:
  explicit ReservedArray(std::size_t count) : count_(count), bytes_(count * sizeof(T) + kSlack_bytes) {
    void* place = mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (place == MAP_FAILED) throw std::bad_alloc();
    // Large pages: a frame touches thousands of small ones, and first touches happen on the way from camera to map.
    if (bytes_ >= kLarge_bytes) (void)madvise(place, bytes_, MADV_HUGEPAGE);
    data_ = static_cast<T*>(place);
  }
  ~ReservedArray() { munmap(data_, bytes_); }
  ReservedArray(const ReservedArray&) = delete;
  ReservedArray& operator=(const ReservedArray&) = delete;

  [[nodiscard]] T& operator[](std::size_t i) { return data_[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return data_[i]; }
  [[nodiscard]] T* data() { return data_; }
  [[nodiscard]] const T* data() const { return data_; }
  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] std::size_t size_bytes() const { return bytes_; }
  /// Has the system provide the first `bytes` now, so that no frame waits for them.
  void touch(std::size_t bytes) {
    constexpr std::size_t kPage_bytes = 4096;
    constexpr int kPopulateWrite = 23;  // MADV_POPULATE_WRITE; not in all headers, nor in kernels before 5.14
    // A fault for each page takes ten times as long, and more in a virtual machine.
    if (madvise(data_, std::min(bytes, bytes_), kPopulateWrite) == 0) return;
    auto* first = reinterpret_cast<volatile char*>(data_);
    for (std::size_t i = 0; i < bytes_ && i < bytes; i += kPage_bytes) first[i] = first[i];
  }
  /// Back to zero bytes; gives the pages back to the system.
  void reset() { madvise(data_, bytes_, MADV_DONTNEED); }

 private:
  static constexpr std::size_t kLarge_bytes = std::size_t{8} << 20;
  static constexpr std::size_t kSlack_bytes = 64;  // vector loads may reach past the last element
  T* data_ = nullptr;
  std::size_t count_;
  std::size_t bytes_;
};

/// Slots of T handed out and taken back by index. One thread, but for high_water().
template <typename T>
class SlotPool {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  explicit SlotPool(std::uint32_t capacity) : items_(capacity), free_(capacity) {}

  /// kNone when the pool is full. The slot's bytes are what its last user left (zero at first).
  [[nodiscard]] std::uint32_t take() {
    if (free_count_ > 0) return free_[--free_count_];
    const std::uint32_t next = high_water();
    if (next >= items_.size()) return kNone;
    high_water_.store(next + 1, std::memory_order_relaxed);
    return next;
  }
  void give_back(std::uint32_t slot) {
    assert(slot < high_water() && free_count_ < items_.size());
    free_[free_count_++] = slot;
  }
  void reset() {
    items_.reset();
    free_count_ = 0;
    high_water_.store(0, std::memory_order_relaxed);
  }

  void touch(std::size_t bytes) { items_.touch(bytes); }

  [[nodiscard]] T& operator[](std::uint32_t slot) { return items_[slot]; }
  [[nodiscard]] const T& operator[](std::uint32_t slot) const { return items_[slot]; }
  [[nodiscard]] std::uint32_t capacity() const { return static_cast<std::uint32_t>(items_.size()); }
  /// Exclusive upper bound of what was ever handed out; any thread.
  [[nodiscard]] std::uint32_t high_water() const { return high_water_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint32_t in_use() const { return high_water() - free_count_; }
  [[nodiscard]] std::uint32_t available() const { return capacity() - in_use(); }
  [[nodiscard]] std::size_t reserved_bytes() const { return items_.size_bytes() + free_.size_bytes(); }

 private:
  ReservedArray<T> items_;
  ReservedArray<std::uint32_t> free_;
  std::uint32_t free_count_ = 0;
  std::atomic<std::uint32_t> high_water_{0};
};

}  // namespace g3d::mapper
