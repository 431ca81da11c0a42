// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/heap_room.hpp"

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <limits>

namespace g3d::hal {
namespace {

constexpr std::uintptr_t kLargePage_bytes = std::uintptr_t{2} << 20;  // of x86-64, and of 64-bit Arm with 4 kB pages
constexpr int kMostFromHeap_bytes = 32 << 20;                         // glibc takes no higher limit
constexpr std::size_t kPiece_bytes = kMostFromHeap_bytes / 2;
constexpr std::size_t kMostPieces = 128;

}  // namespace

bool make_heap_room(std::size_t bytes) {
  bytes = std::min(bytes, kMostPieces * kPiece_bytes - 1);
  // The heap would give the room back at once, and arrays would get mappings of their own, too small for large pages.
  (void)::mallopt(M_MMAP_THRESHOLD, kMostFromHeap_bytes);
  (void)::mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  (void)::mallopt(M_TOP_PAD, static_cast<int>(bytes));
  // In pieces, as a larger one would be a mapping of its own; more than one, as the heap may have some room already.
  std::array<void*, kMostPieces> pieces{};
  std::uintptr_t start = std::numeric_limits<std::uintptr_t>::max();
  std::uintptr_t last = 0;
  for (std::size_t i = 0; i < bytes / kPiece_bytes + 1; ++i) {
    pieces[i] = std::malloc(kPiece_bytes);
    start = std::min(start, reinterpret_cast<std::uintptr_t>(pieces[i]));
    last = std::max(last, reinterpret_cast<std::uintptr_t>(pieces[i]));
  }
  const auto end = reinterpret_cast<std::uintptr_t>(::sbrk(0));
  for (void* const piece : pieces) std::free(piece);
  (void)::mallopt(M_TOP_PAD, kLargePage_bytes);
  if (start == 0 || last + kPiece_bytes > end) return false;
  const std::uintptr_t first = (start + kLargePage_bytes - 1) / kLargePage_bytes * kLargePage_bytes;
  (void)::madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
  return true;
}

}  // namespace g3d::hal
