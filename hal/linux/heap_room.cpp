// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/heap_room.hpp"

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <limits>

namespace g3d::hal {
namespace {

constexpr std::uintptr_t kLargePage_bytes = std::uintptr_t{2} << 20;  // of x86-64, and of 64-bit Arm with 4 kB pages
constexpr int kMostFromHeap_bytes = 32 << 20;                         // glibc takes no higher limit

}  // namespace

bool make_heap_room(std::size_t bytes) {
  constexpr auto kMost = static_cast<std::size_t>(std::numeric_limits<int>::max());
  // The heap would give the room back at once, and arrays would get mappings of their own, too small for large pages.
  (void)::mallopt(M_MMAP_THRESHOLD, kMostFromHeap_bytes);
  (void)::mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  (void)::mallopt(M_TOP_PAD, static_cast<int>(std::min(bytes, kMost)));
  void* const piece = std::malloc(kMostFromHeap_bytes / 2);
  const auto start = reinterpret_cast<std::uintptr_t>(piece);
  const auto end = reinterpret_cast<std::uintptr_t>(::sbrk(0));
  std::free(piece);
  (void)::mallopt(M_TOP_PAD, kLargePage_bytes);
  if (piece == nullptr || end < start || end - start < bytes) return false;
  const std::uintptr_t first = (start + kLargePage_bytes - 1) / kLargePage_bytes * kLargePage_bytes;
  (void)::madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
  return true;
}

}  // namespace g3d::hal
