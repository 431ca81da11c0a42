// SPDX-License-Identifier: Apache-2.0
// The machine under the kernels, played by a processor: the threads of a block take turns in random order between two
// barriers, so that a result which depends on the order shows as a difference, and sanitizers see every access.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#define G3D_GPU
#define G3D_GPU_SHARED

namespace g3d::mapper::cuda {

class Block {
 public:
  /// `order`: all thread numbers, in the order in which they take turns.
  Block(int block_index, int block_count, std::span<const int> order)
      : index(block_index), count(block_count), order_(order) {}
  template <typename F>
  void each(F&& f) const {
    for (const int thread : order_) f(thread);
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

 private:
  std::array<T, kThreads> values_;
};

template <typename T>
T exchange_sum(T* p, T v) {
  const T old = *p;
  *p = static_cast<T>(old + v);
  return old;
}
inline std::uint32_t atomic_add(std::uint32_t* p, std::uint32_t v) { return exchange_sum(p, v); }
inline std::int32_t atomic_add(std::int32_t* p, std::int32_t v) { return exchange_sum(p, v); }
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
inline std::uint32_t atomic_max(std::uint32_t* p, std::uint32_t v) {
  const std::uint32_t old = *p;
  *p = old > v ? old : v;
  return old;
}
template <typename T>
T atomic_cas(T* p, T expected, T v) {
  const T old = *p;
  if (old == expected) *p = v;
  return old;
}

}  // namespace g3d::mapper::cuda
