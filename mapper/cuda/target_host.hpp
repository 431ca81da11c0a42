// SPDX-License-Identifier: Apache-2.0
// The machine under the kernels, played by a processor: the threads of a block take turns in random order between two
// barriers, so that a result which depends on the order shows as a difference, and sanitizers see every access.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#define G3D_GPU
// Kept from block to block, as on a card: what a block reads before it wrote it is what another left there.
#define G3D_GPU_SHARED static thread_local

namespace g3d::mapper::cuda {

/// One or more warps of 32 threads of a block that work on the same thing.
template <int kWarps>
class Team {
 public:
  static constexpr int kThreads = 32 * kWarps;
  /// `order`: all threads of the block, in the order in which they take turns.
  Team(int block_index, int block_count, std::span<const int> order, int number) : in_block(number) {
    const int here = static_cast<int>(order.size()) / kThreads;
    index = block_index * here + in_block;
    count = block_count * here;
    std::size_t n = 0;
    for (const int thread : order) {
      if (thread / kThreads == number) order_[n++] = thread % kThreads;
    }
  }
  template <typename F>
  void each(F&& f) const {
    for (const int thread : order_) f(thread);
  }
  template <typename F>
  void lanes(F&& f) const {
    each(f);
  }
  int index = 0;
  int count = 0;
  int in_block;

 private:
  std::array<int, kThreads> order_{};
};

class Block {
 public:
  /// `order`: all thread numbers, in the order in which they take turns.
  Block(int block_index, int block_count, std::span<const int> order)
      : index(block_index), count(block_count), order_(order) {}
  template <typename F>
  void each(F&& f) const {
    for (const int thread : order_) f(thread);
  }
  template <typename F>
  void lanes(F&& f) const {
    each(f);
  }
  template <int kWarps, typename F>
  void teams(F&& f) const {
    for (const int thread : order_) {  // a team comes when its first thread does
      if (thread % Team<kWarps>::kThreads == 0) f(Team<kWarps>(index, count, order_, thread / Team<kWarps>::kThreads));
    }
  }
  int index;
  int count;

 private:
  std::span<const int> order_;
};

template <typename T, int kThreads>
class PerThread {
 public:
  T& operator[](int thread) { return values_[static_cast<std::size_t>(thread)]; }
  [[nodiscard]] T peer(int thread, int bits) const { return values_[static_cast<std::size_t>(thread ^ bits)]; }
  [[nodiscard]] T of(int thread, int lane) const {
    const int index = thread / 32 * 32 + lane;
    return values_[static_cast<std::size_t>(index)];
  }
  [[nodiscard]] std::uint32_t ballot(int thread) const {
    std::uint32_t lanes = 0;
    for (int lane = 0; lane < 32; ++lane) lanes |= of(thread, lane) != 0 ? 1U << lane : 0U;
    return lanes;
  }

 private:
  std::array<T, kThreads> values_;
};

inline std::uint32_t atomic_add(std::uint32_t* p, std::uint32_t v) {
  const std::uint32_t old = *p;
  *p = old + v;
  return old;
}
inline std::int64_t atomic_add_long(std::int64_t* p, std::int64_t v) {
  const std::int64_t old = *p;
  *p = old + v;
  return old;
}
inline std::uint32_t atomic_or(std::uint32_t* p, std::uint32_t v) {
  const std::uint32_t old = *p;
  *p = old | v;
  return old;
}
inline std::uint32_t atomic_min(std::uint32_t* p, std::uint32_t v) {
  const std::uint32_t old = *p;
  *p = old < v ? old : v;
  return old;
}
inline void fence() {}
template <typename T>
T atomic_cas(T* p, T expected, T v) {
  const T old = *p;
  if (old == expected) *p = v;
  return old;
}

}  // namespace g3d::mapper::cuda
